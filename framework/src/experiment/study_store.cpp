#include "study_store.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <utility>

#include "aslio/core/errors.hpp"
#include "aslio/io/writers.hpp"

namespace aslio::experiment {

namespace {

namespace fs = std::filesystem;

constexpr const char* kIdentityFile = "identity.txt";
constexpr const char* kPartial = ".partial-";

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

/// As large as when it was made. An identity.txt of earlier versions has no size: the bag must be there.
bool has_bag(const fs::path& folder) {
  std::ifstream stream(folder / kIdentityFile);
  std::string line;
  std::getline(stream, line);
  bool any = false;
  while (std::getline(stream, line)) {
    const std::size_t space = line.find(' ');
    if (space == std::string::npos) continue;
    std::error_code error;
    const auto bytes = fs::file_size(folder / line.substr(space + 1), error);
    if (error || fmt::to_string(bytes) != line.substr(0, space)) return false;
    any = true;
  }
  return any || !bags_in(folder).empty();
}

/// By name alone, and, for other data of the same name (another scale or another version of the scene), with identity.
std::vector<fs::path> places(const fs::path& root, const StudyData& data) {
  return {root / data.name, root / fmt::format("{}-{}", data.name, data.identity.substr(0, 8))};
}

void create(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw DataError(fmt::format("{}: cannot create the folder: {}", folder.string(), error.message()));
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

bool is_leftover(std::string_view name, std::string_view begin) {
  return name.starts_with(begin) && digits_only(name.substr(begin.size()), "0123456789");
}

FolderLock::~FolderLock() {
  if (file_ >= 0) ::close(file_);
}

FolderLock::FolderLock(FolderLock&& other) noexcept : file_(std::exchange(other.file_, -1)) {}

FolderLock& FolderLock::operator=(FolderLock&& other) noexcept {
  std::swap(file_, other.file_);
  return *this;
}

std::optional<FolderLock> FolderLock::take(const fs::path& folder, bool exclusive) {
  FolderLock lock;
  lock.file_ = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (lock.file_ < 0 || !lock.change(exclusive)) return std::nullopt;
  return lock;
}

FolderLock FolderLock::of_output(const fs::path& folder, const fs::path& output) {
  constexpr int kTries = 60;
  for (int i = 0; i < kTries; ++i) {
    if (auto lock = take(folder, true)) return std::move(*lock);
    ::poll(nullptr, 0, 50);
  }
  throw ConfigError(
      fmt::format("--output {}: another `aslio experiment` is at work there; wait for it, or name another folder",
                  output.string()));
}

bool FolderLock::change(bool exclusive) const { return ::flock(file_, (exclusive ? LOCK_EX : LOCK_SH) | LOCK_NB) == 0; }

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
  std::error_code ignored;
  return identity_of(folder) == identity && fs::exists(folder / "dataset.yaml", ignored) && has_bag(folder) &&
         (!world_ || fs::exists(folder / kWorldFile, ignored));
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
  create(folder);
  auto lock = FolderLock::take(folder, true);
  if (!lock) throw DataError(fmt::format("{}: the folder has just been made and cannot be locked", folder.string()));
  entries_.insert_or_assign(data.name, Entry{.folder = folder, .made = true, .lock = std::move(*lock)});
  return folder;
}

fs::path StudyStore::commit(const StudyData& data) {
  Entry& entry = entries_.at(data.name);
  io::AtomicFile identity(entry.folder / kIdentityFile);
  identity.write(identity_text(data, entry.folder));
  identity.close();
  entry.lock.change(false);
  std::error_code error;
  for (const fs::path& folder : places(root_, data)) {
    remove_broken(data, folder);
    fs::rename(entry.folder, folder, error);  // refuses where a folder with content stands
    if (error) continue;
    entry.folder = folder;
    keep_small_files(data, folder);
    return folder;
  }
  // Another study has been faster.
  abandon(data);
  if (const auto folder = find(data)) return *folder;
  throw DataError(fmt::format("{}: simulated data cannot be put there: {}", root_.string(), error.message()));
}

void StudyStore::remove_broken(const StudyData& data, const fs::path& folder) const {
  std::error_code ignored;
  const bool whole = fs::exists(folder / "dataset.yaml", ignored) && has_bag(folder);  // maybe without the world
  if (whole || identity_of(folder) != data.identity) return;
  const auto lock = FolderLock::take(folder, true);
  if (lock) fs::remove_all(folder, ignored);
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
  create(target);
  std::vector<const char*> files = {"truth.tum", "overlap.csv", "scene.yaml", "preview.svg"};
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
