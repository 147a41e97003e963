#pragma once
/// Who is at work in a folder.

#include <filesystem>
#include <optional>
#include <string>

namespace aslio::experiment {

/// A lock on a folder that other processes see; given up at the end.
class FolderLock {
 public:
  FolderLock() = default;
  ~FolderLock();
  FolderLock(FolderLock&& other) noexcept;
  FolderLock& operator=(FolderLock&& other) noexcept;
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

  /// Of the folder that has this name when the lock is held. Nothing when another process holds a lock that excludes
  /// this one, or the folder is not there. On a file system without locks nobody is
  /// kept out: excludes() says so. Throws DataError where it cannot be opened.
  static std::optional<FolderLock> take(const std::filesystem::path& folder, bool exclusive);
  /// The exclusive lock of an output folder. A study that was killed may leave a child behind that holds its lock for
  /// as long as it takes to notice: tried for 3 s. Throws ConfigError when another study is at work there, and
  /// DataError as take().
  static FolderLock of_output(const std::filesystem::path& folder, const std::filesystem::path& output);
  /// Is another process at work in a folder that is there? Where that cannot be told, no.
  static bool is_held(const std::filesystem::path& folder, bool exclusive);
  /// From the other kind, at once or not at all.
  bool change(bool exclusive) const;
  /// False: the file system has no locks, as some of clusters have none.
  bool excludes() const { return excludes_; }
  /// What is to be said of such a folder.
  static std::string without_locks(const std::filesystem::path& folder);

 private:
  bool is_of(const std::filesystem::path& folder) const;

  int file_ = -1;
  bool excludes_ = true;
};

}  // namespace aslio::experiment
