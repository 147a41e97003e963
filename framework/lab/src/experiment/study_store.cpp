#include "study_store.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <utility>

#include "aslio/core/errors.hpp"
#include "aslio/io/writers.hpp"
#include "study_files.hpp"

namespace aslio::experiment {

namespace {

namespace fs = std::filesystem;

constexpr const char* kIdentityFile = "identity.txt";
constexpr const char* kPartial = ".partial-";
/// Those that stay in the output when the data go.
constexpr std::array kSmallFiles = {"truth.tum", "overlap.csv", "scene.yaml", "preview.svg"};
/// What else `aslio simulate` writes beside its bag.
constexpr std::array kOtherFiles = {"dataset.yaml", "sensor.yaml", "truth.csv", "log.txt", kWorldFile};

std::string identity_of(const fs::path& folder) {
  std::ifstream stream(folder / kIdentityFile);
  std::string text;
  std::getline(stream, text);
  return text;
}

std::vector<fs::path> bags_in(const fs::path& folder) {
  std::vector<fs::path> bags;
  std::error_code error;
  for (auto at = fs::directory_iterator(folder, error); !error && at != fs::directory_iterator(); at.increment(error)) {
    if (at->path().extension() == ".bag") bags.push_back(at->path());
  }
  std::sort(bags.begin(), bags.end());
  return bags;
}

/// Content of identity.txt: the identity, and a line "BYTES NAME" for the bag, which may be lost or cut off later.
std::string identity_text(const StudyData& data, const fs::path& folder) {
  std::string text = data.identity + "\n";
  for (const fs::path& bag : bags_in(folder)) {
    std::error_code error;
    const auto bytes = fs::file_size(bag, error);
    if (!error) text += fmt::format("{} {}\n", bytes, bag.filename().string());
  }
  return text;
}

struct NamedBag {
  std::string bytes, name;
};

std::vector<NamedBag> bags_named_in(const fs::path& folder) {
  std::ifstream stream(folder / kIdentityFile);
  std::string line;
  std::getline(stream, line);
  std::vector<NamedBag> bags;
  while (std::getline(stream, line)) {
    const std::size_t space = line.find(' ');
    if (space != std::string::npos) bags.push_back({line.substr(0, space), line.substr(space + 1)});
  }
  return bags;
}

/// As large as when it was made. An identity.txt of earlier versions has no size: the bag must be there.
bool has_bag(const fs::path& folder) {
  const std::vector<NamedBag> named = bags_named_in(folder);
  if (named.empty()) return !bags_in(folder).empty();
  return std::all_of(named.begin(), named.end(), [&](const NamedBag& bag) {
    std::error_code error;
    const auto bytes = fs::file_size(folder / bag.name, error);
    return !error && fmt::to_string(bytes) == bag.bytes;
  });
}

/// All that a study or one of its runs reads, but the world.
bool is_whole(const fs::path& folder) {
  const auto there = [&](const char* file) { return has_content(folder / file); };
  return there("dataset.yaml") && there("sensor.yaml") && has_bag(folder) &&
         std::all_of(kSmallFiles.begin(), kSmallFiles.end(), there);
}

/// Is a file of this name one that was written with the data?
bool is_of_data(const std::string& name, const StudyData& data, const std::vector<NamedBag>& bags) {
  const auto same = [&](const char* file) { return name == file; };
  return name == kIdentityFile || name == data.scene.stem().string() + ".bag" ||
         std::any_of(kSmallFiles.begin(), kSmallFiles.end(), same) ||
         std::any_of(kOtherFiles.begin(), kOtherFiles.end(), same) ||
         std::any_of(bags.begin(), bags.end(), [&](const NamedBag& bag) { return name == bag.name; });
}

/// By name alone, and, for other data of the same name (another scale or another version of the scene), with identity.
std::vector<fs::path> places(const fs::path& root, const StudyData& data) {
  return {root / data.name, root / fmt::format("{}-{}", data.name, data.identity.substr(0, 8))};
}

bool digits_only(std::string_view text, std::string_view digits) {
  return !text.empty() && text.find_first_not_of(digits) == std::string_view::npos;
}

/// As partial() makes them, of one recording or (empty) of all.
bool is_partial(std::string_view name, const std::string& recording) {
  const std::size_t id = name.rfind('-'), identity = id == std::string_view::npos ? id : name.rfind('-', id - 1);
  if (!name.starts_with(kPartial) || identity == std::string_view::npos) return false;
  const bool ours = recording.empty() || name.substr(0, identity) == kPartial + recording;
  return ours && digits_only(name.substr(id + 1), "0123456789") &&
         digits_only(name.substr(identity + 1, id - identity - 1), "0123456789abcdef");
}

}  // namespace

bool has_content(const fs::path& file) {
  std::error_code error;
  return fs::is_regular_file(file, error) && fs::file_size(file, error) > 0 && !error;
}

StudyStore::StudyStore(fs::path output, const std::optional<fs::path>& shared, bool keep, bool world)
    : output_(std::move(output)),
      root_(shared ? *shared : output_ / "simulated"),
      own_root_(!shared),
      keep_(keep),
      world_(world) {}

StudyStore::~StudyStore() {
  std::error_code ignored;
  if (own_root_) fs::remove(root_, ignored);  // only when it is empty
}

/// Whole data of this identity: `aslio simulate` writes dataset.yaml last, and the identity is written after it.
bool StudyStore::holds(const fs::path& folder, const std::string& identity) const {
  return identity_of(folder) == identity && is_whole(folder) && (!world_ || has_content(folder / kWorldFile));
}

std::optional<fs::path> StudyStore::find(const StudyData& data) {
  for (const fs::path& folder : places(root_, data)) {
    if (!holds(folder, data.identity)) continue;
    auto lock = FolderLock::take(folder, false);
    if (!lock || !holds(folder, data.identity)) continue;  // another study is about to remove them
    keep_small_files(data, folder);
    entries_.insert_or_assign(data.name, Entry{.folder = folder, .made = false, .lock = std::move(*lock)});
    // Data inside the output were left by an earlier call of this study, and serve nobody else.
    entries_[data.name].made = own_root_;
    return folder;
  }
  return std::nullopt;
}

fs::path StudyStore::partial(const StudyData& data) const {
  return root_ / fmt::format("{}{}-{}-{}", kPartial, data.name, data.identity.substr(0, 8), ::getpid());
}

fs::path StudyStore::begin(const StudyData& data) {
  const fs::path folder = partial(data);
  std::error_code ignored;
  fs::remove_all(folder, ignored);
  create_folder(folder);
  auto lock = FolderLock::take(folder, true);
  if (!lock) throw DataError(fmt::format("{}: the folder has just been made and cannot be locked", folder.string()));
  entries_.insert_or_assign(data.name, Entry{.folder = folder, .made = true, .lock = std::move(*lock)});
  return folder;
}

fs::path StudyStore::commit(const StudyData& data, const std::function<void(const std::string&)>& warn) {
  Entry& entry = entries_.at(data.name);
  io::AtomicFile identity(entry.folder / kIdentityFile);
  identity.write(identity_text(data, entry.folder));
  identity.close();
  entry.lock.change(false);
  std::error_code error;
  std::optional<fs::path> foreign;
  for (const fs::path& folder : places(root_, data)) {
    const auto found = remove_broken(data, folder);
    if (!foreign) foreign = found;
    fs::rename(entry.folder, folder, error);  // refuses where a folder with content stands
    if (error) continue;
    entry.folder = folder;
    if (foreign) {
      warn(fmt::format(
          "warning: {}: files of these data are missing or cut off, and {} is not from `aslio simulate`. The folder "
          "stays as it is; the data are in {}. Move your own files elsewhere and remove the folder",
          foreign->parent_path().string(), foreign->filename().string(), folder.filename().string()));
    }
    keep_small_files(data, folder);
    return folder;
  }
  // Another study has been faster.
  abandon(data);
  if (const auto folder = find(data)) return *folder;
  const std::vector<fs::path> tried = places(root_, data);
  throw DataError(
      fmt::format("{}: simulated data cannot be put there as {} or {}: {}; move your own files elsewhere and remove "
                  "these folders, or name another place",
                  root_.string(), tried[0].filename().string(), tried[1].filename().string(), error.message()));
}

std::optional<fs::path> StudyStore::remove_broken(const StudyData& data, const fs::path& folder) const {
  // Data without the world that this study asks for are made again whole, in the same place.
  const auto broken = [&] { return identity_of(folder) == data.identity && !holds(folder, data.identity); };
  if (!broken()) return std::nullopt;
  const auto lock = FolderLock::take(folder, true);
  if (!lock || !broken()) return std::nullopt;  // another study reads them, or has just put whole ones there
  const std::vector<NamedBag> bags = bags_named_in(folder);
  std::error_code error, ignored;
  std::vector<fs::path> files;
  for (auto at = fs::directory_iterator(folder, error); !error && at != fs::directory_iterator(); at.increment(error)) {
    const bool regular = fs::is_regular_file(at->symlink_status(ignored));
    if (!regular || !is_of_data(at->path().filename().string(), data, bags)) return at->path();
    if (at->path().filename() != kIdentityFile) files.push_back(at->path());
  }
  if (error) return std::nullopt;
  for (const fs::path& file : files) fs::remove(file, ignored);
  fs::remove(folder / kIdentityFile, ignored);  // last: what a kill leaves is still known for what it is
  fs::remove(folder, ignored);                  // only when it is empty
  return std::nullopt;
}

void StudyStore::abandon(const StudyData& data) {
  const auto entry = entries_.find(data.name);
  if (entry == entries_.end()) return;
  std::error_code ignored;
  fs::remove_all(entry->second.folder, ignored);
  entries_.erase(entry);
}

void StudyStore::release(const StudyData& data) {
  const auto entry = entries_.find(data.name);
  if (entry == entries_.end()) return;
  // Where another study reads them, it is left to its owner to remove them.
  if (entry->second.made && !keep_ && entry->second.lock.change(true)) {
    // Under the name of half-written data first: what a kill in the middle leaves goes with the next call.
    std::error_code error, ignored;
    fs::rename(entry->second.folder, partial(data), error);
    if (error) fs::remove(entry->second.folder / kIdentityFile, ignored);  // what is left is not taken for whole
    fs::remove_all(error ? entry->second.folder : partial(data), ignored);
  }
  entries_.erase(entry);
}

std::size_t StudyStore::made() const {
  return static_cast<std::size_t>(
      std::count_if(entries_.begin(), entries_.end(), [](const auto& entry) { return entry.second.made; }));
}

void StudyStore::keep_small_files(const StudyData& data, const fs::path& folder) const {
  const fs::path target = output_ / "data" / data.name;
  create_folder(target);
  std::vector<const char*> files(kSmallFiles.begin(), kSmallFiles.end());
  if (world_) files.push_back(kWorldFile);
  for (const char* file : files) {
    std::error_code error;
    fs::copy_file(folder / file, target / file, fs::copy_options::overwrite_existing, error);
    if (error) throw DataError(fmt::format("{}: cannot be written: {}", (target / file).string(), error.message()));
  }
}

void StudyStore::remove_leftovers(const std::string& recording) const {
  std::error_code error;
  std::vector<fs::path> found;
  for (auto at = fs::directory_iterator(root_, error); !error && at != fs::directory_iterator(); at.increment(error)) {
    if (is_partial(at->path().filename().string(), recording)) found.push_back(at->path());
  }
  for (const fs::path& folder : found) {
    const auto lock = FolderLock::take(folder, true);
    if (lock) fs::remove_all(folder, error);
  }
}

}  // namespace aslio::experiment
