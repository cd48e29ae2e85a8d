// The command `typodont bench models`. It measures every contact model on the same tissue, with the same hand and
// clock, and compares the results with the exact solution. The name of a row is "tissue, motion, model: measure". Its
// column `knob` contains the setting by which the model becomes more accurate or faster.
#include <fmt/format.h>
#include <malloc.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <memory>
#include <random>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/base/log.h"
#include "engine/base/measure.h"
#include "engine/base/units.h"
#include "haptics/bench.h"
#include "haptics/bench/model_settings.h"
#include "haptics/bench/model_tissues.h"
#include "haptics/bench/scene.h"
#include "haptics/bench/timing.h"
#include "haptics/bench/wanderer.h"
#include "haptics/contact_method.h"
#include "haptics/lockstep.h"

namespace typodont::haptics {

namespace {

using namespace bench;

constexpr double kStiffness = 1000;      // N/m, stiffness of tissue and coupling
constexpr double kSpecificEnergy = 8e9;  // J/m³, specific energy of the tissue
// N; the direction of a force is evaluated only if the force is at least this, because a tiny force has no meaningful
// direction
constexpr double kLeast = 0.02;
// number of ticks after which the hand has reached the surface and the force has risen completely
constexpr int kSettled = 100;
// number of ticks after which a bur counts as stopped by a sheet; burs that come through need at most 600
constexpr int kBreakThroughTicks = 1500;
// m; if the bur is deeper than this below the surface, it has fallen through the tissue
constexpr double kFallen = 8e-3;
constexpr double kDynamicFriction = 0.15;  // dynamic friction coefficient of every tissue in the bench
// N; if the force on a hand that has moved through a sheet is at least this, the sheet still holds the tool back
constexpr double kHeld = 0.1;
constexpr double kHostileForce = 8;  // N, force limit for tests with erratic hands
constexpr double kLedger = 1e-9;     // J, a test passes if the balance of the energy ledger is never below minus this
constexpr std::uint64_t kSeed = 1;   // seed of all random hands
constexpr double kEscapeSheets_mm[] = {0.2, 0.5, 1.0};  // mm, thickness of the sheets of the motion "escape"
constexpr double kGrid = 0.02e-3;                       // m, spacing of the grid with which a swept volume is measured

/// A contact model with one value of the setting by which it becomes more accurate or faster.
struct Setting {
  std::string model, knob;
  SharedContactMethod method;
  double voxel_mm = 0.1;  // mm, voxel size of the tissue's distance field
};

/// Returns the settings with which a model is measured on a tissue, from fast to accurate. For an anatomical tissue,
/// the tissue itself states the voxel sizes; models with meshes use the mesh of the tissue without changes.
std::vector<Setting> settings_of(const std::string& model, const ModelTissue& tissue, bool quick) {
  std::vector<Setting> all;
  const bool anatomy = !tissue.voxels_mm.empty();
  if (model == "packing") {
    const std::vector<int> counts = anatomy ? std::vector{36'000}
                                    : quick ? std::vector{2000, 10'000}
                                            : std::vector{10'000, 36'000, 100'000};
    for (const int spheres : counts) {
      all.push_back({model, fmt::format("{} spheres", spheres),
                     method_of(fmt::format(R"({{"packing": {{"spheres": {}}}}})", spheres)),
                     anatomy ? tissue.voxels_mm.back() : kDefaultVoxel});
    }
  } else if (anatomy && (model == "mesh_lod" || model == "vertex")) {
    all.push_back({model, "its mesh",
                   model == "mesh_lod" ? method_of(R"({"mesh_lod": {"levels": [2000000]}})") : method_of("\"vertex\""),
                   tissue.voxels_mm.back()});
  } else if (model == "mesh_lod") {
    for (const int vertices : quick ? std::vector{2000, 8000} : std::vector{2000, 8000, 33'000}) {
      all.push_back({model, fmt::format("{} vertices", vertices),
                     method_of(fmt::format(R"({{"mesh_lod": {{"vertices": {0}, "levels": [{0}]}}}})", vertices)),
                     kDefaultVoxel});
    }
  } else {
    const std::vector<double> voxels = anatomy ? tissue.voxels_mm
                                       : quick ? std::vector{0.2, 0.1}
                                               : std::vector{0.2, 0.1, 0.05};
    for (const double voxel_mm : voxels) {
      all.push_back({model, fmt::format("voxel {:g} mm", voxel_mm), contact_method(model, "bench models"), voxel_mm});
    }
  }
  return all;
}

/// Returns the default setting of a model.
Setting default_setting(const std::string& model) {
  const DefaultMethod usual = default_method(model);
  return {model, usual.knob, usual.method, kDefaultVoxel};
}

bool wanted(const std::vector<std::string>& names, const std::string& name) {
  return names.empty() || std::find(names.begin(), names.end(), name) != names.end();
}

double allocated_bytes() {
  const auto info = mallinfo2();
  return static_cast<double>(info.uordblks + info.hblkhd);
}

double angle_between(const dvec3& a, const dvec3& b) {
  return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b)) / kDegree;
}

/// Statistics of the force in a run: the error against the exact force, the largest step between two ticks, and the
/// energy that the force gave to the hand.
class ForceRecord {
 public:
  /// Adds one tick: the force, the exact force, and the hand's displacement since the last tick. If `counts` is false,
  /// the tick does not count for the error.
  void add(const dvec3& force, const dvec3& truth, const dvec3& moved, bool counts) {
    // During this displacement, the force of the previous tick acted.
    given_ += glm::dot(last_, moved);
    most_given_ = std::max(most_given_, given_);
    if (counts) {
      step_ = std::max(step_, glm::length(force - last_) - glm::length(truth - last_truth_));
      const double size = glm::length(truth);
      if (size > kLeast) {
        ++count_;
        const double angle = glm::length(force) > 0 ? angle_between(force, truth) : 180;
        angle_squares_ += angle * angle;
        worst_angle_ = std::max(worst_angle_, angle);
        const double off = glm::length(force) / size - 1;
        size_squares_ += off * off;
        worst_size_ = std::max(worst_size_, std::abs(off));
      }
    }
    last_ = force, last_truth_ = truth;
  }
  double angle() const { return std::sqrt(angle_squares_ / std::max(count_, 1)); }
  double worst_angle() const { return worst_angle_; }
  double size() const { return std::sqrt(size_squares_ / std::max(count_, 1)); }
  double worst_size() const { return worst_size_; }
  /// Returns the largest change (N) of the force from one tick to the next, after the change of the exact force is
  /// subtracted.
  double step() const { return step_; }
  /// Returns the largest value (J), over the run, of the energy that the force has given to the hand since the start.
  double given() const { return most_given_; }

 private:
  dvec3 last_{0}, last_truth_{0};
  double given_ = 0, most_given_ = 0, step_ = 0;
  double angle_squares_ = 0, worst_angle_ = 0, size_squares_ = 0, worst_size_ = 0;
  int count_ = 0;
};

class ModelBench {
 public:
  ModelBench(const ModelBenchOptions& options, std::vector<BenchRow>& rows) : options_(options), rows_(rows) {}

  void all() {
    std::vector<ModelTissue> tissues = analytic_tissues();
    for (const ModelAnatomy& a : options_.anatomies) tissues.push_back(mesh_tissue(a));
    for (const ModelTissue& tissue : tissues) {
      if (!wanted(options_.tissues, tissue.name)) continue;
      const Course slide = slide_course(tissue, options_.quick ? 800 : 2500), tap = tap_course(tissue);
      for (const std::string& model : contact_method_names()) {
        for (const Setting& setting : settings_of(model, tissue, options_.quick)) {
          tissue_ = &tissue, setting_ = &setting;
          if (wanted(options_.motions, "slide")) timed("slide", [&] { follow("slide", slide); });
          if (wanted(options_.motions, "tap")) timed("tap", [&] { follow("tap", tap); });
          if (wanted(options_.motions, "drag")) timed("drag", [&] { drag(slide); });
          if (wanted(options_.motions, "drill") && tissue.solid) timed("drill", [&] { drill(); });
        }
        const Setting usual = default_setting(model);
        setting_ = &usual;
        if (wanted(options_.motions, "break-through") && !tissue.solid)
          timed("break-through", [&] { break_through(); });
        // With the option `quick`, the motion "hostile" is omitted, because a short run does not come to the tissue.
        if (wanted(options_.motions, "hostile") && tissue.voxels_mm.empty() && !options_.quick)
          timed("hostile", [&] { hostile(); });
      }
    }
    for (const double thickness_mm : kEscapeSheets_mm) {
      const ModelTissue sheet = sheet_tissue(thickness_mm);
      if (!wanted(options_.motions, "escape") || !wanted(options_.tissues, sheet.name)) continue;
      for (const std::string& model : contact_method_names()) {
        const Setting usual = default_setting(model);
        tissue_ = &sheet, setting_ = &usual;
        timed("escape", [&] { escape(thickness_mm); });
      }
    }
  }

 private:
  /// Runs `measure` and logs its CPU time, because a full comparison takes long.
  template <class Measure>
  void timed(const char* motion, Measure&& measure) const {
    const double start = cpu_seconds(RUSAGE_SELF);
    measure();
    log::info("{}, {}, {}, {}: {:.1f} s of processor", tissue_->name, motion, setting_->model, setting_->knob,
              cpu_seconds(RUSAGE_SELF) - start);
  }

  void add(const char* motion, std::string_view measure, double value, const char* unit, double ns = BenchRow::kNone) {
    rows_.push_back({.name = fmt::format("{}, {}, {}: {}", tissue_->name, motion, setting_->model, measure),
                     .knob = setting_->knob,
                     .error = value,
                     .error_unit = unit,
                     .time_ns = ns,
                     .per = std::isfinite(ns) ? "tick" : ""});
  }

  ServoSettings servo_settings() const {
    ServoSettings settings;
    settings.tool = head(HeadShape::kSphere, 2 * kProbeRadius, 2 * kProbeRadius);
    settings.method = setting_->method;
    settings.stiffness = kStiffness;
    return settings;
  }

  /// Measures a hand whose path does not depend on the force. The servo has a spring, but no damper and no friction.
  void follow(const char* motion, const Course& course) {
    ServoSettings settings = servo_settings();
    settings.friction = settings.cutting = false;
    settings.damping = 0;
    const double bytes = allocated_bytes();
    TissueVolume volume = tissue_->make(setting_->voxel_mm);
    const double seconds = cpu_seconds(RUSAGE_SELF);
    Scene scene(std::move(volume), settings);
    const double setup = cpu_seconds(RUSAGE_SELF) - seconds, held = allocated_bytes() - bytes;
    ForceRecord asked, felt;
    double penetration = 0;
    std::vector<double> times(course.hand.size(), 1e18);
    // All passes do the same work. Interrupts make single ticks longer. So the shortest time of a tick over all passes
    // is its time without interrupts.
    for (int pass = 0; pass < (options_.quick ? 1 : kRuns); ++pass) {
      // Moves the hand far away, so that contact and snapshots start again. In these ticks, every model moves its proxy
      // to the hand. So the jump of the hand causes no error on the path that follows.
      for (int i = 0; i < 3; ++i) scene.tick({dvec3(0, 0, 0.2)}, 0);
      for (int i = 0; i < 1000; ++i) scene.tick({course.hand.front()}, 0);
      for (std::size_t i = 0; i < course.hand.size(); ++i) {
        times[i] = std::min(times[i], scene.tick({course.hand[i]}, 0));
        if (pass > 0) continue;
        const dvec3 truth = kStiffness * (course.truth[i] - course.hand[i]);
        const dvec3 moved = i > 0 ? course.hand[i] - course.hand[i - 1] : dvec3(0);
        const bool counts = static_cast<int>(i) >= kSettled;
        asked.add(scene.last.f_model_W, truth, moved, counts);
        felt.add(scene.last.f_T_W, truth, moved, counts);
        const ExactShape::Nearest at = tissue_->shape.nearest(scene.last.X_WG.p, 2 * kProbeRadius);
        penetration = std::max(penetration, kProbeRadius - at.distance);
      }
    }
    const double median = quantile(times, 0.5);
    const bool slides = motion == std::string_view("slide");
    if (slides) {
      add(motion, "direction", asked.angle(), "degree, rms", median);
      add(motion, "direction", asked.worst_angle(), "degree, greatest");
      add(motion, "magnitude", 100 * asked.size(), "%, rms", median);
    }
    add(motion, "magnitude", 100 * asked.worst_size(), "%, greatest");
    add(motion, "penetration", std::max(penetration, 0.0) / kMillimetre, "mm, greatest", median);
    add(motion, "step, asked", std::max(asked.step(), 0.0), "N per tick more than the exact force");
    add(motion, "step, felt", std::max(felt.step(), 0.0), "N per tick more than the exact force");
    add(motion, "energy given, asked", 1e6 * asked.given(), "uJ");
    add(motion, "energy given, felt", 1e6 * felt.given(), "uJ");
    add(motion, "tick, 99.9 %", BenchRow::kNone, "", quantile(times, 0.999));
    if (!slides) return;
    add("set-up", "memory", held / (1 << 20), "MiB");
    add("set-up", "elements", static_cast<double>(scene.carver.body().elements()), "elements");
    add("set-up", "time", setup, "s of processor");
  }

  /// Measures drilling with a round bur. The simulated hand has 0.15 kg, pushes with 1 N and oscillates.
  void drill() {
    ServoSettings settings = servo_settings();
    settings.spindle.free_speed = 300 * kKrpm;
    double counted = 0, lost = 0, swept = 0, work = 0, shrink = 0;
    std::vector<double> cutting;
    const int ticks = options_.quick ? 300 : 600;
    std::vector<std::pair<dvec3, dvec3>> ways;
    ForceRecord asked, felt;
    bool fell = false;
    const auto run = [&] {
      Scene scene(tissue_->make(setting_->voxel_mm), settings);
      const double before = total(scene.carver.volume().volumes());
      ways.clear(), cutting.clear();
      asked = felt = {};
      work = 0;
      PressingHand hand(*tissue_);
      std::vector<double> times;
      for (int i = 0; i < ticks; ++i) {
        const dvec3 old = hand.position();
        const dvec3 x = hand.next(scene.last.f_T_W, settings.tick);
        const Nanos start = thread_cpu_time();
        const std::uint64_t cuts = scene.last.cuts;
        times.push_back(scene.tick({x}, 1));
        if (scene.last.cuts > cuts) {
          cutting.push_back(static_cast<double>(thread_cpu_time() - start) - times.back());
          ways.emplace_back(scene.cut.X_WA.p, scene.cut.X_WB.p);
        }
        work += scene.last.cutting_power * settings.tick;
        asked.add(scene.last.f_model_W, dvec3(0), x - old, i >= kSettled);
        felt.add(scene.last.f_T_W, dvec3(0), x - old, i >= kSettled);
        shrink = hand.depth();
        fell = shrink > kFallen;
        if (fell) break;
      }
      counted = total(scene.last.removed);
      lost = before - total(scene.carver.volume().volumes());
      return times;
    };
    const std::vector<double> times = options_.quick ? run() : least_of(run);
    add("drill", "fell through", fell ? 1 : 0, "1: the hand fell through the tissue");
    if (fell) return;
    swept = swept_volume(tissue_->shape, ways, kProbeRadius, kGrid);
    const double median = quantile(times, 0.5);
    if (swept > 0) {
      add("drill", "removal", 100 * std::abs(lost / swept - 1), "% of the swept volume", median);
      add("drill", "removal, as the servo counts", 100 * std::abs(counted / swept - 1), "% of the swept volume");
      add("drill", "removal against the motor's work", 100 * std::abs(lost * kSpecificEnergy / work - 1), "%");
    }
    add("drill", "depth", shrink / kMillimetre, "mm, no error: what was drilled");
    add("drill", "step, asked", std::max(asked.step(), 0.0), "N a tick");
    add("drill", "step, felt", std::max(felt.step(), 0.0), "N a tick");
    add("drill", "tick, 99.9 %", BenchRow::kNone, "", quantile(times, 0.999));
    if (!cutting.empty()) {
      add("drill", "carver's cut, median", BenchRow::kNone, "", quantile(cutting, 0.5));
      add("drill", "carver's cut, 99.9 %", BenchRow::kNone, "", quantile(cutting, 0.999));
    }
  }

  /// Measures friction: repeats the slide and compares the ratio of tangential to normal force with Coulomb's
  /// coefficient.
  void drag(const Course& course) {
    ServoSettings settings = servo_settings();
    settings.cutting = false;
    settings.damping = 0;
    Scene scene(tissue_->make(setting_->voxel_mm), settings);
    double squares = 0, worst = 0;
    int count = 0;
    for (std::size_t i = 0; i < course.hand.size(); ++i) {
      scene.tick({course.hand[i]}, 0);
      if (static_cast<int>(i) < kSettled) continue;
      const ExactShape::Nearest at = tissue_->shape.nearest(scene.last.X_WG.p, 2 * kProbeRadius);
      const dvec3 n = glm::normalize(scene.last.X_WG.p - at.p), f = scene.last.f_T_W;
      const double normal = glm::dot(f, n), tangential = glm::length(f - normal * n);
      if (!(normal > kLeast)) continue;
      const double off = tangential / normal / kDynamicFriction - 1;
      squares += off * off, worst = std::max(worst, std::abs(off)), ++count;
    }
    add("drag", "friction", 100 * std::sqrt(squares / std::max(count, 1)), "%, rms");
    add("drag", "friction", 100 * worst, "%, greatest");
  }

  /// Presses the bur of drill() onto a sheet. Measures whether the bur comes through the sheet, and which force
  /// remains.
  void break_through() {
    ServoSettings settings = servo_settings();
    settings.spindle.free_speed = 300 * kKrpm;
    Scene scene(tissue_->make(setting_->voxel_mm), settings);
    dvec3 x(0.2e-3, 0.1e-3, 0.15e-3 + kProbeRadius + 2e-5), v(0);
    const dvec3 rest = x;
    const double beyond = -(0.15e-3 + kProbeRadius);  // m; a bur lower than this has left the sheet
    double step = 0, left = 0, through = 0;
    dvec3 last(0);
    for (int i = 0; i < kBreakThroughTicks && x.z > -kFallen; ++i) {
      dvec3 pull = 2000.0 * (rest - x);
      pull.z = -1;
      v += settings.tick * (pull - 5.0 * v + scene.last.f_T_W) / 0.15;
      x += settings.tick * v;
      scene.tick({x}, 1);
      step = std::max(step, glm::length(scene.last.f_T_W - last));
      last = scene.last.f_T_W;
      if (scene.last.X_WG.p.z < beyond - 1e-4) left = std::max(left, glm::length(last));
      if (through == 0 && scene.last.X_WG.p.z < beyond) through = settings.tick * i;
    }
    add("break-through", "through", through > 0 ? 1 : 0, "1: the bur came through");
    if (through > 0) {
      add("break-through", "time", through, "s until the bur has left the sheet");
      add("break-through", "force left", left, "N beyond the sheet, greatest");
    }
    add("break-through", "step, felt", step, "N a tick");
  }

  /// Moves hands through a sheet, by 1, 5 and 20 mm per tick. Measures how many hands escape: on the other side of the
  /// sheet, no force pulls them back.
  void escape(double thickness_mm) {
    ServoSettings settings = servo_settings();
    settings.friction = settings.cutting = false;
    Scene scene(tissue_->make(setting_->voxel_mm), settings);
    std::mt19937_64 random(kSeed);
    std::uniform_real_distribution<double> anywhere(-1, 1);
    const int hands = options_.quick ? 10 : 100;
    for (const double step_mm : {1.0, 5.0, 20.0}) {
      int escaped = 0;
      for (int k = 0; k < hands; ++k) {
        const double x = anywhere(random), y = anywhere(random), lean = 0.3 * anywhere(random);
        const dvec3 from(1e-3 * x, 1e-3 * y, 3e-3), way(1e-3 * lean, 0, -1e-3 * step_mm);
        // Moves the hand far away, so that the model forgets the last contact.
        for (int i = 0; i < 3; ++i) scene.tick({dvec3(0, 0, 0.2)}, 0);
        for (int i = 0; i < 20; ++i) scene.tick({from}, 0);
        dvec3 hand = from;
        while (hand.z > -4e-3) scene.tick({hand += way}, 0);
        for (int i = 0; i < 100; ++i) scene.tick({hand}, 0);
        escaped += scene.last.f_T_W.z < kHeld;
      }
      add("escape", fmt::format("hands of {:g} mm a tick", step_mm), 100.0 * escaped / hands, "% escaped");
      rows_.back().size = step_mm, rows_.back().size_unit = "mm a tick";
      rows_.back().knob += fmt::format(", sheet {:g} mm", thickness_mm);
    }
  }

  /// Tests motions that no human makes. The force must be finite and limited, and must not give energy to the hand.
  void hostile() {
    ServoSettings settings = servo_settings();
    settings.spindle.free_speed = 300 * kKrpm;
    settings.force_limit = kHostileForce;
    constexpr int hands = 6, ticks = 1500;
    double worst = 0, greatest = 0, bad = 0, through = 0, slowest = 0;
    int with_energy = 0;
    std::vector<double> times;
    for (int hand = 0; hand < hands; ++hand) {
      const bool drills = hand % 2 == 1;
      Scene scene(tissue_->make(setting_->voxel_mm), settings);
      ErraticHand wanderer(kSeed + static_cast<std::uint64_t>(hand), tissue_->start);
      double least = 0;
      for (int i = 0; i < ticks; ++i) {
        // Every two seconds the hand moves down into the tissue.
        const Pose at = wanderer.next(settings.tick);
        const dvec3 down = (1.5e-3 + kProbeRadius) * 0.5 * (1 - std::cos(kPi * 1e-3 * i)) *
                           glm::normalize(tissue_->shape.nearest(tissue_->start, 5e-3).p - tissue_->start);
        times.push_back(scene.tick({at.p + down, at.R}, drills ? 1 : 0));
        const ServoTick& tick = scene.last;
        if (!is_finite(tick.f_T_W) || !is_finite(tick.X_WG.p) || !std::isfinite(tick.energy)) ++bad;
        greatest = std::max(greatest, glm::length(tick.f_T_W));
        least = std::min(least, tick.energy);
        if (!drills && !tissue_->solid && tick.X_WG.p.z < 0 && std::abs(tick.X_WG.p.x) < 2e-3 &&
            std::abs(tick.X_WG.p.y) < 2e-3)
          through = 1;
      }
      worst = std::max(worst, -least);
      with_energy += least < -kLedger;
    }
    slowest = quantile(times, 0.999);
    add("hostile", "energy given, felt", 1e6 * worst, "uJ");
    add("hostile", "hands with energy", 100.0 * with_energy / hands, "% of the hands");
    add("hostile", "greatest force", greatest, "N");
    add("hostile", "ticks not finite", bad, "ticks");
    if (!tissue_->solid) add("hostile", "through the sheet", through, "1: a probe came through");
    add("hostile", "tick, 99.9 %", BenchRow::kNone, "", slowest);
  }

  const ModelBenchOptions& options_;
  std::vector<BenchRow>& rows_;
  const ModelTissue* tissue_ = nullptr;
  const Setting* setting_ = nullptr;
};

}  // namespace

std::vector<std::string> model_bench_tissues() {
  std::vector<std::string> names;
  for (const ModelTissue& tissue : analytic_tissues()) names.push_back(tissue.name);
  for (const double thickness_mm : kEscapeSheets_mm) names.push_back(sheet_tissue(thickness_mm).name);
  return names;
}

std::vector<BenchRow> bench_models(const ModelBenchOptions& options) {
  std::vector<BenchRow> rows;
  ModelBench(options, rows).all();
  return rows;
}

}  // namespace typodont::haptics
