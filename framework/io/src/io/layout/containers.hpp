#pragma once
/// Containers of messages by a layout: single files, folders of rosbag2, and parts of either.

#include <functional>
#include <memory>

#include "aslio/io/layout_writer.hpp"
#include "aslio/io/message_writer.hpp"

namespace aslio::io {

/// Opens what `name` stands for. `opened` gets each file or folder, relative to the folder of the place.
std::unique_ptr<MessageWriter> open_container(const Layout& layout, const LayoutPlace& place, const std::string& name,
                                              std::vector<std::filesystem::path>& opened);

}  // namespace aslio::io
