// Feeds a target with its corpus, and with what small damage makes of it. No libFuzzer: the same inputs in every build.
#include <algorithm>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <map>
#include <string>
#include <vector>

#include "fuzz/target.hpp"

#define ASLIO_FUZZ_TARGETS(use)                                                                                       \
  use(bag) use(cloud) use(csv) use(folder) use(imu) use(kitti) use(livox) use(mcap) use(outcomes) use(packets)        \
      use(pipeline) use(plugin) use(recording) use(reference) use(report) use(scan) use(scene) use(sensor) use(study) \
          use(text) use(tum)

namespace aslio::fuzz {

#define ASLIO_FUZZ_DECLARE(name) void fuzz_##name(Bytes bytes);
ASLIO_FUZZ_TARGETS(ASLIO_FUZZ_DECLARE)

namespace {

using Target = void (*)(Bytes);
using Input = std::vector<std::uint8_t>;

#define ASLIO_FUZZ_ENTRY(name) {#name, &fuzz_##name},
const std::map<std::string, Target> kTargets = {ASLIO_FUZZ_TARGETS(ASLIO_FUZZ_ENTRY)};

/// A sequence that is the same everywhere (splitmix64).
class Sequence {
 public:
  std::size_t below(std::size_t count) {
    std::uint64_t z = state_ += 0x9e3779b97f4a7c15U;
    z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9U;
    z = (z ^ (z >> 27U)) * 0x94d049bb133111ebU;
    return static_cast<std::size_t>((z ^ (z >> 31U)) % count);
  }

 private:
  std::uint64_t state_ = 1;
};

std::vector<Input> corpus_of(const std::string& name) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(std::filesystem::path(ASLIO_FUZZ_CORPUS) / name)) {
    files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  std::vector<Input> inputs;
  for (const auto& path : files) {
    std::ifstream file(path, std::ios::binary);
    inputs.emplace_back(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
  }
  return inputs;
}

/// Cut short, bits flipped, lengths overwritten by large ones, a part doubled or removed.
Input damaged(const Input& whole, Sequence& random) {
  Input input = whole;
  const std::size_t at = random.below(input.size());
  const auto place = input.begin() + static_cast<std::ptrdiff_t>(at);
  const std::size_t count = 1 + random.below(std::min<std::size_t>(input.size() - at, 64));
  const auto end = place + static_cast<std::ptrdiff_t>(count);
  switch (random.below(5)) {
    case 0:
      input.resize(at);
      break;
    case 1:
      *place = static_cast<std::uint8_t>(*place ^ (1U << random.below(8)));
      break;
    case 2:
      std::fill(place, place + static_cast<std::ptrdiff_t>(std::min<std::size_t>(count, 8)), std::uint8_t{0xff});
      break;
    case 3:
      input.erase(place, end);
      break;
    default: {
      const Input part(place, end);
      input.insert(place, part.begin(), part.end());
    }
  }
  return input;
}

int replay(const std::string& name, Target target) {
  const std::vector<Input> corpus = corpus_of(name);
  must(!corpus.empty(), "a target has a corpus");
  for (const Input& input : corpus) target(input);
  target({});
  // As many in every build, so that a failure can be found again; the clock would decide otherwise.
  constexpr std::size_t kDamaged = 300;
  Sequence random;
  for (std::size_t i = 0; i < kDamaged; ++i) {
    const Input& whole = corpus[i % corpus.size()];
    if (whole.empty()) continue;
    Input input = damaged(whole, random);
    if (i % 3 == 0 && !input.empty()) input = damaged(input, random);
    target(input);
  }
  std::printf("%s: %zu files, %zu damaged ones\n", name.c_str(), corpus.size(), kDamaged);
  return 0;
}

}  // namespace
}  // namespace aslio::fuzz

int main(int count, char** arguments) {
  const auto& targets = aslio::fuzz::kTargets;
  const auto target = count == 2 ? targets.find(arguments[1]) : targets.end();
  if (target == targets.end()) {
    std::fprintf(stderr, "usage: test_fuzz TARGET\n");
    return 2;
  }
  return aslio::fuzz::replay(target->first, target->second);
}
