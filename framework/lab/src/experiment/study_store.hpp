#pragma once
/// Simulated data on disk: made under another name, shared with other studies, removed when they have served.

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "aslio/experiment/study.hpp"
#include "folder_lock.hpp"

namespace aslio::experiment {

/// A file that can be read from, and not an empty one, as a disk without room leaves it.
bool has_content(const std::filesystem::path& file);

/// The surfaces of a simulated world, where the study asks for them.
inline constexpr const char* kWorldFile = "world.ply";

/// The data of one study. Not for several threads.
class StudyStore {
 public:
  /// `output`: of the study; `shared`: folder of simulated data for any number of studies.
  /// `world`: data without world.ply are not whole.
  StudyStore(std::filesystem::path output, const std::optional<std::filesystem::path>& shared, bool keep, bool world);
  ~StudyStore();
  StudyStore(const StudyStore&) = delete;
  StudyStore& operator=(const StudyStore&) = delete;

  /// A study that was killed leaves half-written data without a lock: they go, of one recording or (empty) of all.
  void remove_leftovers(const std::string& recording) const;
  /// The folder of these data if they are there, whole; they stay until release().
  std::optional<std::filesystem::path> find(const StudyData& data);
  /// An empty folder to simulate into.
  std::filesystem::path begin(const StudyData& data);
  /// The folder of begin() holds all: it gets its name. `warn` is told of broken data that were left for the sake of
  /// what lies beside them.
  std::filesystem::path commit(const StudyData& data, const std::function<void(const std::string&)>& warn);
  /// The folder of begin() is given up.
  void abandon(const StudyData& data);
  /// No run needs these data any more.
  void release(const StudyData& data);
  /// How many of the data were made here and are still there.
  std::size_t made() const;

 private:
  struct Entry {
    std::filesystem::path folder;
    bool made = false;  ///< by this study: it removes them
    FolderLock lock;
  };
  std::filesystem::path partial(const StudyData& data) const;
  bool holds(const std::filesystem::path& folder, const std::string& identity) const;
  /// What is left of these data where a file of them is gone or cut off: the new ones take its place. The folder stays
  /// as it is where anything else lies in it, which is somebody's: returns its path.
  std::optional<std::filesystem::path> remove_broken(const StudyData& data, const std::filesystem::path& folder) const;
  /// Truth and overlap are small, and what figures need: they stay.
  void keep_small_files(const StudyData& data, const std::filesystem::path& folder) const;

  std::filesystem::path output_, root_;
  bool own_root_, keep_, world_;
  std::map<std::string, Entry> entries_;  // by name of the data
};

}  // namespace aslio::experiment
