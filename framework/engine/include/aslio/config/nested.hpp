#pragma once
/// A stage named inside a parameter block. Resolved and validated when the file is read, built later.

#include <functional>
#include <memory>
#include <stdexcept>
#include <string>

namespace aslio {

struct BuildContext;  // stages/build_context.hpp

/// Base of every stage interface. Each interface S declares `static constexpr std::string_view family`.
class Stage {
 public:
  virtual ~Stage() = default;
};

namespace config {

class Binder;  // config/binder.hpp

/// A validated stage: its type, its parameters as resolved, and how to make it. Immutable, shared.
struct StageRecipe {
  std::string family;
  std::string type;
  std::function<std::unique_ptr<Stage>(const BuildContext&)> make;
};

/// Slot for a stage of interface S in a Params. `Nested<MotionModel> motion{"imu_midpoint"};` names the default type;
/// an empty default makes the key required.
template <class S>
class Nested {
 public:
  Nested() = default;
  explicit Nested(std::string default_type) : type_(std::move(default_type)) {}

  /// The chosen type, or the default before the file is read.
  const std::string& type() const { return recipe_ ? recipe_->type : type_; }
  /// Builds the stage. Pre: the block has been parsed (the pipeline has done so before any stage is built).
  std::unique_ptr<S> make(const BuildContext& context) const {
    if (!recipe_) throw std::logic_error("stage '" + type_ + "' is built before its configuration has been read");
    return std::unique_ptr<S>(static_cast<S*>(recipe_->make(context).release()));
  }
  bool resolved() const { return recipe_ != nullptr; }
  void resolve(std::shared_ptr<const StageRecipe> recipe) { recipe_ = std::move(recipe); }

 private:
  std::string type_;
  std::shared_ptr<const StageRecipe> recipe_;
};

}  // namespace config
}  // namespace aslio
