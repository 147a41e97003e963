#include "recordings/unpacked.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cstdlib>
#include <stdexcept>
#include <string>

namespace aslio::test {
namespace {

namespace fs = std::filesystem;

const fs::path kUnpacked = fs::path(ASLIO_BINARY_DIR) / "recordings";

/// One process at a time unpacks; the kernel lets go of the lock when its process ends, however it ends.
class Lock {
 public:
  Lock() {
    fs::create_directories(kUnpacked);
    file_ = open((kUnpacked / "lock").c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0644);
    if (file_ < 0 || flock(file_, LOCK_EX) != 0) throw std::runtime_error("cannot lock " + kUnpacked.string());
  }
  ~Lock() { close(file_); }
  Lock(const Lock&) = delete;
  Lock& operator=(const Lock&) = delete;

 private:
  int file_ = -1;
};

void run(const std::string& command) {
  // Fixed commands on configured paths.
  if (std::system(command.c_str()) != 0) throw std::runtime_error("failed: " + command);
}

}  // namespace

fs::path recorded(const fs::path& name) {
  const fs::path path = fs::path(ASLIO_RECORDINGS_DIR) / name;
  if (!fs::exists(path)) throw std::runtime_error("missing recording " + path.string() + ": set ASLIO_RECORDINGS_DIR");
  return path;
}

fs::path unpacked_avia() {
  const Lock lock;
  const fs::path bag = kUnpacked / "avia_corridor.bag", part = kUnpacked / "avia_corridor.part";
  if (fs::exists(bag)) return bag;
  run("xz -dc '" + recorded("avia_corridor.bag.xz").string() + "' > '" + part.string() + "'");
  fs::rename(part, bag);
  return bag;
}

fs::path unpacked_kitti(const std::string& drive) {
  const Lock lock;
  const fs::path root = kUnpacked / ("kitti_" + drive), part = kUnpacked / ("kitti_" + drive + ".part");
  if (fs::exists(root)) return root;
  fs::create_directories(part);
  run("python3 '" + recorded("unpack_kitti.py").string() + "' '" + part.string() + "' " + drive + " > '" +
      (kUnpacked / "unpack.log").string() + "'");
  fs::rename(part, root);
  return root;
}

}  // namespace aslio::test
