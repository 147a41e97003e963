#include "containers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "aslio/core/errors.hpp"
#include "aslio/io/mcap/writer.hpp"
#include "aslio/io/rosbag/writer.hpp"
#include "aslio/io/rosbag2/writer.hpp"
#include "rows.hpp"

namespace aslio::io {
namespace {

namespace fs = std::filesystem;

/// Writers one after the other, each for its share of the time.
class PartsWriter final : public MessageWriter {
 public:
  using Make = std::function<std::unique_ptr<MessageWriter>(std::int64_t part)>;
  PartsWriter(Make make, std::int64_t parts, TimeNs begin, TimeNs end)
      : make_(std::move(make)), parts_(parts), begin_(begin), length_(std::max<TimeNs>(1, end - begin)) {}

  std::uint32_t add(const Connection& connection) override {
    connections_.push_back(connection);
    ids_.push_back(part_ ? part_->add(connection) : 0);
    return static_cast<std::uint32_t>(connections_.size() - 1);
  }

  void write(std::uint32_t connection, TimeNs time, std::span<const std::uint8_t> bytes) override {
    const double share = static_cast<double>(time - begin_) / static_cast<double>(length_);
    const auto part =
        std::clamp<std::int64_t>(static_cast<std::int64_t>(share * static_cast<double>(parts_)), 0, parts_ - 1);
    open_until(part);
    part_->write(ids_.at(connection), time, bytes);
  }

  /// Parts without a message are written as well: readers miss a number that is not there.
  void close() override {
    open_until(parts_ - 1);
    part_->close();
  }

 private:
  void open_until(std::int64_t part) {
    while (opened_ <= part) {
      if (part_) part_->close();
      part_ = make_(opened_++);
      for (std::size_t i = 0; i < connections_.size(); ++i) ids_[i] = part_->add(connections_[i]);
    }
  }

  Make make_;
  std::int64_t parts_, opened_ = 0;
  TimeNs begin_, length_;
  std::vector<Connection> connections_;
  std::vector<std::uint32_t> ids_;
  std::unique_ptr<MessageWriter> part_;
};

std::unique_ptr<MessageWriter> open_file(const Layout& layout, const fs::path& path) {
  if (layout.container == Container::rosbag) {
    const bool lz4 = layout.compression == Packing::lz4;
    return std::make_unique<rosbag::BagWriter>(
        path, rosbag::WriterOptions{.compression = lz4 ? rosbag::Compression::lz4 : rosbag::Compression::none});
  }
  if (layout.container == Container::rosbag2) {
    return std::make_unique<rosbag2::DatabaseWriter>(
        path, rosbag2::DatabaseOptions{.compress = layout.compression == Packing::zstd});
  }
  const auto compression = layout.compression == Packing::none  ? mcap::Compression::none
                           : layout.compression == Packing::lz4 ? mcap::Compression::lz4
                                                                : mcap::Compression::zstd;
  return std::make_unique<mcap::McapWriter>(path, mcap::WriterOptions{.compression = compression});
}

std::string_view extension_of(Container container) {
  return container == Container::rosbag ? ".bag" : container == Container::rosbag2 ? ".db3" : ".mcap";
}

/// A folder of rosbag2, whose parts are within.
std::unique_ptr<MessageWriter> open_folder(const Layout& layout, const LayoutPlace& place, const fs::path& folder) {
  rosbag2::FolderOptions options;
  options.storage = layout.container == Container::mcap ? "mcap" : "sqlite3";
  options.compressed_messages = layout.container == Container::rosbag2 && layout.compression == Packing::zstd;
  options.make = [layout](const fs::path& stem) {
    const fs::path path = stem.string() + std::string(extension_of(layout.container));
    return rosbag2::FolderOptions::OpenPart{open_file(layout, path), path.filename().string()};
  };
  const bool within = layout.files.front().find("{part}") == std::string::npos;
  // A message at the very end belongs to the last part.
  if (within && layout.parts > 1) {
    options.part_s = to_seconds(place.end - place.begin + 1) / static_cast<double>(layout.parts);
  }
  return rosbag2::open_folder_writer(folder, std::move(options));
}

std::unique_ptr<MessageWriter> open_one(const Layout& layout, const LayoutPlace& place, const std::string& name,
                                        std::vector<fs::path>& opened) {
  const fs::path path = place_of(place, name);
  opened.push_back(path.lexically_relative(place.folder));
  const bool file = path.extension() == extension_of(layout.container);
  return file ? open_file(layout, path) : open_folder(layout, place, path);
}

}  // namespace

std::unique_ptr<MessageWriter> open_container(const Layout& layout, const LayoutPlace& place, const std::string& name,
                                              std::vector<fs::path>& opened) {
  const bool numbered = name.find("{part}") != std::string::npos;
  if (layout.container == Container::rosbag && fs::path(name).extension() != ".bag") {
    throw ConfigError(fmt::format("files: '{}' is no name of a bag; let it end in .bag", name));
  }
  if (!numbered) return open_one(layout, place, name, opened);
  auto make = [layout, place, name, &opened](std::int64_t part) {
    return open_one(layout, place, filled_in(name, "part", std::to_string(part)), opened);
  };
  return std::make_unique<PartsWriter>(std::move(make), layout.parts, place.begin, place.end);
}

}  // namespace aslio::io
