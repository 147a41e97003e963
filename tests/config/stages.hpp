#pragma once
/// Two small families and a file format of their own, so that the tests of config need no plugin.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "aslio/config/load.hpp"
#include "aslio/core/errors.hpp"
#include "aslio/plugin/registry.hpp"
#include "aslio/stages/build_context.hpp"

namespace aslio::test {

class Clock : public Stage {
 public:
  static constexpr std::string_view family = "clocks";
  virtual double tick() const = 0;
};

class Spring : public Stage {
 public:
  static constexpr std::string_view family = "springs";
  virtual double stiffness() const = 0;
};

class Coil final : public Spring {
 public:
  struct Params {
    double stiffness = 2.0;
  };
  static void describe(config::Binder& b, Params& p) {
    b.real("stiffness", p.stiffness, "N/m", {.above = 0.0}, "force per length");
  }
  Coil(const Params& p, const BuildContext&) : stiffness_(p.stiffness) {}
  double stiffness() const override { return stiffness_; }

 private:
  double stiffness_;
};

class Leaf final : public Spring {
 public:
  struct Params {};
  static void describe(config::Binder&, Params&) {}
  Leaf(const Params&, const BuildContext&) {}
  double stiffness() const override { return 7.0; }
};

class Pendulum final : public Clock {
 public:
  enum class Swing : unsigned char { small, wide };
  struct Params {
    double period = 1.0;
    std::optional<double> length;
    std::int64_t teeth = 30;
    double step_min = 0.1;
    double step_max = 0.5;
    bool loud = false;
    Swing swing = Swing::small;
    std::vector<std::string> uses{"map"};
    config::Nested<Spring> spring{"coil"};
  };
  static void describe(config::Binder& b, Params& p) {
    b.real("period", p.period, "s", {.min = 0.001, .max = 10.0}, "time of one swing");
    b.optional_real("length", p.length, "m", {.above = 0.0, .max = 5.0}, "from the period", "length of the rod");
    b.integer("teeth", p.teeth, "", {.min = 2, .max = 100}, "teeth of the wheel");
    b.real("step_min", p.step_min, "s", {.min = 0.0, .below = 1.0}, "shortest step");
    b.real("step_max", p.step_max, "s", {.min = 0.0}, "longest step");
    b.flag("loud", p.loud, "whether it can be heard");
    b.choice("swing", p.swing, {{"small", Swing::small}, {"wide", Swing::wide}}, "how far it swings");
    b.texts("uses", p.uses, {"overlap", "map", "match"}, "where it acts");
    b.stage("spring", p.spring, "what drives it");
    b.removed("window_size", "use frame_length");
    b.require(p.step_min <= p.step_max, "step_min", "must not exceed step_max");
  }
  Pendulum(const Params& p, const BuildContext& context) : params_(p), spring_(p.spring.make(context)) {}
  double tick() const override { return params_.period * spring_->stiffness(); }

 private:
  Params params_;
  std::unique_ptr<Spring> spring_;
};

class Quartz final : public Clock {
 public:
  struct Params {
    double frequency = 32768.0;
  };
  static void describe(config::Binder& b, Params& p) {
    b.real("frequency", p.frequency, "Hz", {.above = 0.0}, "of the crystal");
  }
  Quartz(const Params& p, const BuildContext&) : frequency_(p.frequency) {}
  double tick() const override { return 1.0 / frequency_; }

 private:
  double frequency_;
};

struct Box {
  std::vector<double> centre{0.0, 0.0, 0.0};
  std::string label;
  static void describe(config::Binder& b, Box& p) {
    b.reals("centre", p.centre, 3, "m", {.min = -100.0, .max = 100.0}, "middle of the box");
    b.text("label", p.label, "what it is");
    b.require(p.label != "forbidden", "label", "must be allowed");
  }
};

/// What the tests read as `schema: aslio/pipeline/1`.
struct Workshop {
  config::Nested<Clock> window;
  std::vector<config::Nested<Clock>> samplers;
  Box frame;
  std::vector<Box> boxes;
  double max_speed = 30.0;
  std::string note;

  static void describe(config::Binder& b, Workshop& p) {
    b.stage("window", p.window, "the clock in the window");
    b.stages("samplers", p.samplers, "the other clocks");
    b.group("frame", p.frame, "what holds it");
    b.groups("boxes", p.boxes, "what stands around");
    b.real("max_speed", p.max_speed, "m/s", {.above = 0.0}, "faster is wrong");
    b.text("note", p.note, "anything");
  }
};

inline plugin::Catalog make_catalog() {
  plugin::Catalog catalog;
  plugin::Registry<Clock> clocks(catalog);
  clocks.add<Pendulum>("pendulum", "swings");
  clocks.add<Quartz>("quartz", "vibrates");
  plugin::Registry<Spring> springs(catalog);
  springs.add<Coil>("coil", "a wound wire");
  springs.add<Leaf>("leaf", "a bent plate");
  return catalog;
}

using Sets = std::vector<config::Override>;

inline config::Loaded<Workshop> read(const std::string& text, const Sets& overrides = {}) {
  const plugin::Catalog catalog = make_catalog();
  return config::parse<Workshop>(std::string("schema: aslio/pipeline/1\n").append(text), "a.yaml",
                                 config::FileKind::pipeline, catalog, overrides);
}

/// Text of the ConfigError; "accepted" when there is none.
inline std::string error_of(const std::string& text, const Sets& overrides = {}) {
  try {
    read(text, overrides);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "accepted";
}

}  // namespace aslio::test
