#pragma once
/// What reading, describing and building need to know of the stages there are. Implemented by plugin::Catalog.

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "aslio/config/nested.hpp"

namespace aslio::config {

/// One registered type, with the type of its parameters erased.
struct StageEntry {
  std::string family;
  std::string type;
  std::string doc;     ///< one sentence
  std::string origin;  ///< "built-in" or the path of the shared object
  /// Fresh default parameters (Params).
  std::function<std::shared_ptr<void>()> defaults;
  /// Describes `params` (made by `defaults`) to a binder.
  std::function<void(Binder&, void* params)> describe;
  /// Builds a stage from `params`.
  std::function<std::unique_ptr<Stage>(const void* params, const BuildContext&)> make;
};

class StageLookup {
 public:
  virtual ~StageLookup() = default;
  /// Null when there is none.
  virtual const StageEntry* find(std::string_view family, std::string_view type) const = 0;
  /// In alphabetical order.
  virtual std::vector<std::string> families() const = 0;
  virtual std::vector<std::string> types(std::string_view family) const = 0;
};

}  // namespace aslio::config
