// `typodont bench models`: every contact model on the same tissue, with the same hand and the same clock, against the
// exact answer. Each row's name is "tissue, motion, model: measure", its knob what trades accuracy for time.
#include <fmt/format.h>
#include <malloc.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/measure.h"
#include "engine/base/units.h"
#include "haptics/bench.h"
#include "haptics/bench/model_tissues.h"
#include "haptics/bench/scene.h"
#include "haptics/bench/timing.h"
#include "haptics/contact_method.h"
#include "haptics/lockstep.h"

namespace typodont::haptics {

namespace {

using namespace bench;

constexpr double kStiffness = 1000;      // N/m, of tissue and coupling
constexpr double kSpecificEnergy = 8e9;  // J/m³
constexpr double kLeast = 0.02;          // N: below it a force has no direction to speak of
constexpr int kSettled = 100;            // ticks until the hand is on the surface and the force's ramp is over
constexpr double kFallen = 8e-3;         // m below the surface, where no bur gets in the time of a run
constexpr double kGrid = 0.02e-3;        // m, of the points that count a swept volume

/// A contact model with one setting of what trades its accuracy for time.
struct Setting {
  std::string model, knob;
  SharedContactMethod method;
  double voxel_mm = 0.1;  // of the tissue's field
};

SharedContactMethod method_of(const std::string& json) {
  return read_contact_method(Json::parse(json, "bench models"));
}

/// The settings of a model that the bench goes through, from cheap to accurate.
std::vector<Setting> settings_of(const std::string& model, bool quick) {
  std::vector<Setting> all;
  if (model == "packing") {
    for (const int spheres : quick ? std::vector{2000, 10'000} : std::vector{10'000, 36'000, 100'000})
      all.push_back({model, fmt::format("{} spheres", spheres),
                     method_of(fmt::format(R"({{"packing": {{"spheres": {}}}}})", spheres))});
  } else if (model == "mesh_lod") {
    for (const int vertices : quick ? std::vector{2000, 8000} : std::vector{2000, 8000, 33'000})
      all.push_back({model, fmt::format("{} vertices", vertices),
                     method_of(fmt::format(R"({{"mesh_lod": {{"vertices": {0}, "levels": [{0}]}}}})", vertices))});
  } else {
    for (const double voxel_mm : quick ? std::vector{0.2, 0.1} : std::vector{0.2, 0.1, 0.05})
      all.push_back({model, fmt::format("voxel {:g} mm", voxel_mm), contact_method(model, "bench models"), voxel_mm});
  }
  return all;
}

bool wanted(const std::vector<std::string>& names, const std::string& name) {
  return names.empty() || std::find(names.begin(), names.end(), name) != names.end();
}

double allocated_bytes() {
  const auto info = mallinfo2();
  return static_cast<double>(info.uordblks + info.hblkhd);
}

double process_seconds() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

double angle_between(const dvec3& a, const dvec3& b) {
  return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b)) / kDegree;
}

/// What a force does over a run: its error against the truth, its largest step, its energy.
class ForceRecord {
 public:
  /// In one tick: the force, what the truth would be, and how far the hand moved since the last tick.
  void add(const dvec3& force, const dvec3& truth, const dvec3& moved, bool counts) {
    // The hand moves against the force of the tick before.
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
  /// N, the largest step in a tick beyond the truth's own step.
  double step() const { return step_; }
  /// J, the most that the force had ever given to the hand.
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
    for (const ModelTissue& tissue : tissues) {
      if (!wanted(options_.tissues, tissue.name)) continue;
      const Course slide = slide_course(tissue, options_.quick ? 800 : 4000), tap = tap_course(tissue);
      for (const std::string& model : contact_method_names()) {
        for (const Setting& setting : settings_of(model, options_.quick)) {
          tissue_ = &tissue, setting_ = &setting;
          if (wanted(options_.motions, "slide")) follow("slide", slide);
          if (wanted(options_.motions, "tap")) follow("tap", tap);
          if (tissue.solid && wanted(options_.motions, "drill")) drill();
        }
      }
    }
  }

 private:
  void add(const char* motion, const char* measure, double value, const char* unit, double ns = BenchRow::kNone) {
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

  /// A hand that goes where the course says, whatever it feels: spring alone, no damper, no friction.
  void follow(const char* motion, const Course& course) {
    ServoSettings settings = servo_settings();
    settings.friction = settings.cutting = false;
    settings.damping = 0;
    const double bytes = allocated_bytes();
    TissueVolume volume = tissue_->make(setting_->voxel_mm);
    const double seconds = process_seconds();
    Scene scene(std::move(volume), settings);
    const double setup = process_seconds() - seconds, held = allocated_bytes() - bytes;
    ForceRecord asked, felt;
    double penetration = 0;
    std::vector<double> times(course.hand.size(), 1e18);
    // Equal passes do equal work: the least time of each tick is the tick's own, interrupts left out.
    for (int pass = 0; pass < (options_.quick ? 1 : kRuns); ++pass) {
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
      // Off the surface again, as far as to the start.
      for (int i = 0; i < 50; ++i) scene.tick({course.hand.front()}, 0);
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
    add(motion, "step, asked", std::max(asked.step(), 0.0), "N a tick beyond the truth's");
    add(motion, "step, felt", std::max(felt.step(), 0.0), "N a tick beyond the truth's");
    add(motion, "energy given, asked", 1e6 * asked.given(), "uJ");
    add(motion, "energy given, felt", 1e6 * felt.given(), "uJ");
    add(motion, "tick, 99.9 %", BenchRow::kNone, "", quantile(times, 0.999));
    if (!slides) return;
    add("set-up", "memory", held / (1 << 20), "MiB");
    add("set-up", "elements", static_cast<double>(scene.carver.body().elements()), "elements");
    add("set-up", "time", setup, "s of processor");
  }

  /// A round bur in a hand of 0.15 kg that pushes with 1 N and swings to and fro.
  void drill() {
    ServoSettings settings = servo_settings();
    settings.spindle.free_speed = 300 * kKrpm;
    const ExactShape::Nearest below = tissue_->shape.nearest(tissue_->start, 5e-3);
    const dvec3 n = glm::normalize(tissue_->start - below.p);
    const dvec3 side = glm::normalize(glm::cross(n, std::abs(n.y) < 0.9 ? dvec3(0, 1, 0) : dvec3(1, 0, 0)));
    const dvec3 rest = below.p + (kProbeRadius + 2e-5) * n;
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
      dvec3 x = rest, v(0);
      std::vector<double> times;
      for (int i = 0; i < ticks; ++i) {
        const dvec3 old = x;
        const dvec3 center = rest + 0.5e-3 * std::sin(2 * kPi * 1e-3 * i) * side;
        dvec3 pull = 2000.0 * (center - x);
        pull -= glm::dot(pull, n) * n;
        v += settings.tick * (pull - 1.0 * n - 5.0 * v + scene.last.f_T_W) / 0.15;
        x += settings.tick * v;
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
        fell = glm::dot(rest - x, n) > kFallen;
        if (fell) break;
      }
      counted = total(scene.last.removed);
      lost = before - total(scene.carver.volume().volumes());
      shrink = glm::dot(rest - x, n);
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

  const ModelBenchOptions& options_;
  std::vector<BenchRow>& rows_;
  const ModelTissue* tissue_ = nullptr;
  const Setting* setting_ = nullptr;
};

}  // namespace

std::vector<BenchRow> bench_models(const ModelBenchOptions& options) {
  std::vector<BenchRow> rows;
  ModelBench(options, rows).all();
  return rows;
}

}  // namespace typodont::haptics
