#pragma once
/// The writers of the kinds of layout.

#include <memory>

#include "aslio/io/layout_writer.hpp"

namespace aslio::io {

std::unique_ptr<LayoutWriter> open_message_layout(const Layout& layout, const LayoutPlace& place);
std::unique_ptr<LayoutWriter> open_folder_layout(const Layout& layout, const LayoutPlace& place);
std::unique_ptr<LayoutWriter> open_kitti_layout(const Layout& layout, const LayoutPlace& place);

}  // namespace aslio::io
