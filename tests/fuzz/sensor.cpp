#include "aslio/io/source.hpp"
#include "aslio/plugin/registry.hpp"
#include "fuzz/yaml.hpp"

ASLIO_FUZZ_TARGET(sensor) { (void)parsed<io::SensorConfig>(bytes, config::FileKind::sensor, plugin::Catalog()); }
