#pragma once
/// The only door to PCL. Plain types only: PCL's binaries and our code may disagree on Eigen's alignment.

#include <string>

namespace aslio::io {

using PointSink = void (*)(void* context, float x, float y, float z, float intensity);

/// Empty text on success, otherwise what is wrong.
std::string read_cloud_with_pcl(const char* path, bool ply, PointSink sink, void* context);

}  // namespace aslio::io
