#pragma once
/// Types of each family by name. Registration is explicit (`register_windows(Registry<WindowStrategy>&)`), never a
/// static initialiser. Nothing but the registry knows a plugin by name.

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "aslio/config/binder.hpp"
#include "aslio/config/stage_lookup.hpp"

namespace aslio::plugin {

using Entry = config::StageEntry;

/// All entries of all families; look-ups are by (family, type). Families and types list in alphabetical order.
class Catalog final : public config::StageLookup {
 public:
  /// Throws ConfigError when (family, type) is taken already, naming both origins.
  void add(Entry entry);
  const Entry* find(std::string_view family, std::string_view type) const override;
  std::vector<std::string> families() const override;
  std::vector<std::string> types(std::string_view family) const override;
  /// Declares a family that may (yet) have no members.
  void declare(std::string_view family);
  /// Origin recorded for the entries added from here on.
  void set_origin(std::string origin) { origin_ = std::move(origin); }
  const std::string& origin() const { return origin_; }

 private:
  std::vector<std::string> families_;
  std::vector<std::unique_ptr<Entry>> entries_;
  std::string origin_ = "built-in";
};

/// Typed view of one family of the catalog. T must have `Params`, `static void describe(config::Binder&, Params&)` and
/// a constructor T(const Params&, const BuildContext&).
template <class S>
class Registry {
 public:
  explicit Registry(Catalog& catalog) : catalog_(&catalog) { catalog.declare(S::family); }

  template <class T>
  void add(std::string_view type, std::string_view doc) {
    using Params = typename T::Params;
    catalog_->add({.family = std::string(S::family),
                   .type = std::string(type),
                   .doc = std::string(doc),
                   .origin = catalog_->origin(),
                   .defaults = [] { return std::static_pointer_cast<void>(std::make_shared<Params>()); },
                   .describe = [](config::Binder& b, void* p) { T::describe(b, *static_cast<Params*>(p)); },
                   .make = [](const void* p, const BuildContext& context) -> std::unique_ptr<Stage> {
                     return std::make_unique<T>(*static_cast<const Params*>(p), context);
                   }});
  }

 private:
  Catalog* catalog_;
};

}  // namespace aslio::plugin
