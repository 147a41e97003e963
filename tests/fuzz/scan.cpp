// Files of points. The first byte: their format.
#include "../../framework/io/src/io/folder/file_columns.hpp"
#include "../../framework/io/src/io/folder/point_file.hpp"
#include "fuzz/target.hpp"

ASLIO_FUZZ_TARGET(scan) {
  if (bytes.empty()) return;
  const Bytes file = bytes.subspan(1);
  io::PointTable table;
  const bool read = accepts([&] {
    switch (bytes[0] % 4) {
      case 0:
        return io::parse_pcd(file, "scan.pcd", table);
      case 1:
        return io::parse_ply(file, "scan.ply", table);
      case 2:
        return io::parse_bin(file, io::declared_columns("x y z intensity time ring:u16", "scan.bin"), table);
      default:
        return io::declared_columns(text_of(file), "scan.bin").describe(table);
    }
  });
  if (!read) return;
  must(table.bytes.empty() || (table.point_step > 0 && table.bytes.size() % table.point_step == 0), "points are whole");
  for (const auto& column : table.columns) must(column.offset < table.point_step, "columns lie in the point");
}
