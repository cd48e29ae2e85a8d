// All contact models on the same tissue, with the same hand and clock, compared with the exact contact. The name of a
// case is motion/tissue/model/setting.
#include <malloc.h>

#include <cstdlib>
#include <memory>
#include <optional>
#include <random>

#include "engine/base/temporary_folder.h"
#include "tests/bench/haptic_scene.h"
#include "tests/bench/model_cases.h"
#include "tests/bench/press_report.h"

namespace typodont::bench {

namespace {

using test::Course;
using test::HapticBench;
using test::kProbeRadius;
using test::ModelTissue;

constexpr double kStiffness = 1000;  // N/m, of tissue and coupling
constexpr double kFriction = 0.15;   // dynamic friction coefficient of the tissue
constexpr double kMinForce = 0.02;   // N; a smaller force has no reliable direction
constexpr int kSettled = 100;        // ticks until the force has risen
constexpr double kWideSheet_mm = 14;

/// A tissue, loaded when its first case runs, and the path of a hand that slides on it.
struct Subject {
  std::function<ModelTissue()> load;
  std::optional<ModelTissue> loaded{};
  std::optional<Course> path{};
  const ModelTissue& tissue() {
    if (!loaded) loaded = load();
    return *loaded;
  }
  const Course& slide() {
    if (!path) path = test::slide_course(tissue(), smoke() ? 400 : 1500);
    return *path;
  }
};

haptics::ServoSettings settings_for(const Setting& setting) {
  haptics::ServoSettings settings;
  settings.tool = round_head(2 * kProbeRadius);
  settings.method = setting.method;
  settings.stiffness = kStiffness;
  settings.spindle.free_speed = 300 * kKrpm;
  return settings;
}

/// Statistics of the force in a run against the exact force.
class ForceRecord {
 public:
  /// Adds a tick. `moved`: the hand's displacement since the last tick, during which the last force acted. `counts`:
  /// false while the force rises.
  void add(const dvec3& force, const dvec3& truth, const dvec3& moved, bool counts) {
    given_ += glm::dot(last_, moved);
    energy = std::max(energy, given_);
    if (counts) {
      step = std::max(step, glm::length(force - last_) - glm::length(truth - last_truth_));
      if (const double size = glm::length(truth); size > kMinForce) {
        ++count_;
        const double angle = glm::length(force) > 0 ? degrees_between(force, truth) : 180;
        angles_ += angle * angle, max_angle = std::max(max_angle, angle);
        sizes_ += std::pow(glm::length(force) / size - 1, 2);
      }
    }
    last_ = force, last_truth_ = truth;
  }
  double angle() const { return std::sqrt(angles_ / std::max(count_, 1)); }  // degree, rms
  double size() const { return std::sqrt(sizes_ / std::max(count_, 1)); }    // relative, rms
  double max_angle = 0;                                                      // degree
  double step = 0;    // N per tick, largest change beyond that of the exact force
  double energy = 0;  // J, largest energy that the force gave to the hand since the start

 private:
  dvec3 last_{0}, last_truth_{0};
  double given_ = 0, angles_ = 0, sizes_ = 0;
  int count_ = 0;
};

double allocated_bytes() {
  const auto info = mallinfo2();
  return static_cast<double>(info.uordblks + info.hblkhd);
}

/// Follows a path that does not depend on the force. The servo has a spring, but no damper and no friction.
void follow(benchmark::State& state, const ModelTissue& tissue, const Course& course, const Setting& setting,
            bool slides) {
  haptics::ServoSettings settings = settings_for(setting);
  settings.friction = settings.cutting = false;
  settings.damping = 0;
  const double bytes = allocated_bytes(), seconds = cpu_seconds(RUSAGE_SELF);
  HapticBench scene = scene_of(tissue.make(setting.voxel_mm), settings);
  const double setup = cpu_seconds(RUSAGE_SELF) - seconds, memory = allocated_bytes() - bytes;
  ForceRecord asked, felt;
  double penetration = 0;
  const std::vector<double> times = least_of([&] {
    // From far away, every model begins again with its proxy at the hand.
    for (int i = 0; i < 3; ++i) scene.tick({dvec3(0, 0, 0.2)});
    for (int i = 0; i < 1000; ++i) scene.tick({course.hand.front()});
    asked = felt = {};
    std::vector<double> run;
    for (std::size_t i = 0; i < course.hand.size(); ++i) {
      scene.tick({course.hand[i]});
      run.push_back(servo_ns(scene.last));
      const dvec3 truth = kStiffness * (course.truth[i] - course.hand[i]);
      const dvec3 moved = i > 0 ? course.hand[i] - course.hand[i - 1] : dvec3(0);
      asked.add(scene.last.f_model_W, truth, moved, static_cast<int>(i) >= kSettled);
      felt.add(scene.last.f_T_W, truth, moved, static_cast<int>(i) >= kSettled);
      const auto at = tissue.shape.nearest(scene.last.X_WG.p, 2 * kProbeRadius);
      penetration = std::max(penetration, kProbeRadius - at.distance);
    }
    return run;
  });
  set_times(state, times);
  state.counters["step_N"] = std::max(felt.step, 0.0);
  state.counters["energy_model_uJ"] = 1e6 * asked.energy;
  state.counters["energy_uJ"] = 1e6 * felt.energy;
  if (!slides) {
    require(felt.energy < 1e-9, "behind the passivity controller, a tap gives the hand no energy: " + setting.model);
    return;
  }
  state.counters["direction_rms_deg"] = asked.angle();
  state.counters["direction_max_deg"] = asked.max_angle;
  state.counters["magnitude_rms_percent"] = 100 * asked.size();
  state.counters["penetration_mm"] = std::max(penetration, 0.0) / kMillimetre;
  state.counters["memory_MiB"] = memory / (1 << 20);
  state.counters["setup_s"] = setup;
  if (tissue.name != "ball" || setting.voxel_mm > kDefaultVoxel) return;
  if (setting.model == "offset") require(asked.angle() < 1e-3, "on a ball, `offset` is right to 0.001 degrees");
  require(asked.angle() < 45, "on a ball, no model is off by 45 degrees: " + setting.model);
}

/// Slides with friction and compares the ratio of tangential to normal force with Coulomb's coefficient.
void drag(benchmark::State& state, const ModelTissue& tissue, const Course& course, const Setting& setting) {
  haptics::ServoSettings settings = settings_for(setting);
  settings.cutting = false;
  settings.damping = 0;
  HapticBench scene = scene_of(tissue.make(setting.voxel_mm), settings);
  double squares = 0;
  int count = 0;
  for (std::size_t i = 0; i < course.hand.size(); ++i) {
    scene.tick({course.hand[i]});
    if (static_cast<int>(i) < kSettled) continue;
    const auto at = tissue.shape.nearest(scene.last.X_WG.p, 2 * kProbeRadius);
    const dvec3 n = glm::normalize(scene.last.X_WG.p - at.p), f = scene.last.f_T_W;
    const double normal = glm::dot(f, n);
    if (!(normal > kMinForce)) continue;
    squares += std::pow(glm::length(f - normal * n) / normal / kFriction - 1, 2), ++count;
  }
  state.counters["friction_error_rms_percent"] = 100 * std::sqrt(squares / std::max(count, 1));
}

/// A hand of 0.15 kg presses a round bur with 1 N and swings.
void drill(benchmark::State& state, const ModelTissue& tissue, const Setting& setting) {
  constexpr double kFallen = 8e-3;  // m, depth below the surface
  const haptics::ServoSettings settings = settings_for(setting);
  std::vector<std::pair<dvec3, dvec3>> ways;
  std::vector<double> carver;
  double lost = 0, depth = 0, step = 0;
  const std::vector<double> times = least_of([&] {
    HapticBench scene = scene_of(tissue.make(setting.voxel_mm), settings);
    const double before = total(scene.carver.volume().volumes());
    test::PressingHand hand(tissue);
    std::vector<double> run;
    ways.clear(), carver.clear();
    step = 0;
    for (int i = 0; i < (smoke() ? 200 : 600); ++i) {
      const dvec3 last = scene.last.f_T_W;
      const Nanos start = thread_cpu_time();
      scene.tick({hand.next(last, settings.tick)}, 1);
      const auto all = static_cast<double>(thread_cpu_time() - start);
      run.push_back(servo_ns(scene.last));
      carver.push_back(all - static_cast<double>(scene.last.cpu_time));
      if (scene.did_cut) ways.emplace_back(scene.cut.X_WA.p, scene.cut.X_WB.p);
      if (i >= kSettled) step = std::max(step, glm::length(scene.last.f_T_W - last));
    }
    depth = hand.depth();
    lost = before - total(scene.carver.volume().volumes());
    return run;
  });
  state.counters["fell_through"] = depth > kFallen;
  if (depth > kFallen) return;
  set_times(state, times);
  const double swept = test::swept_volume(tissue.shape, ways, kProbeRadius, smoke() ? 1e-4 : 2e-5);
  if (swept > 0) state.counters["removal_error_percent"] = 100 * std::abs(lost / swept - 1);
  state.counters["depth_mm"] = depth / kMillimetre;
  state.counters["step_N"] = step;
  state.counters["carver_slow_ns"] = quantile(carver, 0.999);
}

/// The hand of drill() with a setting of the intermediate surface. Lag: distance by which the felt surface holds the
/// ball above the tissue.
void follow_surface(benchmark::State& state, const ModelTissue& tissue, const std::string& json) {
  const haptics::ServoSettings settings = settings_for({"offset", "", method_of(json)});
  std::vector<double> lags;  // m
  double step = 0, sent_step = 0, removed = 0;
  const std::vector<double> times = least_of([&] {
    HapticBench scene = scene_of(tissue.make(kDefaultVoxel), settings);
    test::PressingHand hand(tissue);
    std::vector<double> run;
    lags.clear();
    step = sent_step = 0;
    for (int i = 0; i < (smoke() ? 200 : 600); ++i) {
      const ServoTick last = scene.last;
      scene.tick({hand.next(last.f_T_W, settings.tick)}, 1);
      run.push_back(servo_ns(scene.last));
      if (i < kSettled) continue;
      step = std::max(step, glm::length(scene.last.f_model_W - last.f_model_W));
      sent_step = std::max(sent_step, glm::length(scene.last.f_T_W - last.f_T_W));
      const dvec3 lowest = scene.last.X_WG.p - kProbeRadius * scene.last.n_C_W;
      lags.push_back(scene.settings.frame.voxel *
                     haptics::sample_linear(scene.patch(), scene.settings.frame.to_voxels(lowest)));
    }
    removed = total(scene.last.removed);
    return run;
  });
  set_times(state, times);
  state.counters["model_step_N"] = step;
  state.counters["step_N"] = sent_step;
  state.counters["lag_median_mm"] = quantile(lags, 0.5) / kMillimetre;
  state.counters["lag_max_mm"] = quantile(lags, 1) / kMillimetre;
  state.counters["removed_mm3"] = removed / kCubicMillimetre;
}

/// The hand of drill() on the thin sheet: does the bur come through, and which force remains beyond?
void break_through(benchmark::State& state, const ModelTissue& sheet, const Setting& setting) {
  const haptics::ServoSettings settings = settings_for(setting);
  HapticBench scene = scene_of(sheet.make(setting.voxel_mm), settings);
  dvec3 x(0.2e-3, 0.1e-3, 0.15e-3 + kProbeRadius + 2e-5), v(0), last(0);
  const dvec3 rest = x;
  const double beyond = -(0.15e-3 + kProbeRadius);  // m; a lower bur has left the sheet
  double step = 0, left = 0, through = 0;
  for (int i = 0; i < 1500 && x.z > -8e-3; ++i) {
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
  state.counters["through"] = through > 0;
  if (through > 0) state.counters["time_s"] = through, state.counters["force_left_N"] = left;
  state.counters["step_N"] = step;
}

/// Hands that pass through a sheet, which is so wide that no tool goes around its edge. A hand escapes if no force
/// pulls it back on the other side.
void escape(benchmark::State& state, double thickness_mm, const Setting& setting) {
  haptics::ServoSettings settings = settings_for(setting);
  settings.friction = settings.cutting = false;
  HapticBench scene = scene_of(test::sheet_tissue(thickness_mm, kWideSheet_mm).make(setting.voxel_mm), settings);
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> anywhere(-1, 1);
  const int hands = smoke() ? 3 : 100;
  for (const double step_mm : {1.0, 5.0, 20.0}) {
    int escaped = 0;
    for (int k = 0; k < hands; ++k) {
      const double x = anywhere(random), y = anywhere(random), lean = 0.3 * anywhere(random);
      const dvec3 from(1e-3 * x, 1e-3 * y, 3e-3), way(1e-3 * lean, 0, -1e-3 * step_mm);
      for (int i = 0; i < 3; ++i) scene.tick({dvec3(0, 0, 0.2)});  // far away, so that the last contact is forgotten
      for (int i = 0; i < 20; ++i) scene.tick({from});
      dvec3 hand = from;
      while (hand.z > -4e-3) scene.tick({hand += way});
      for (int i = 0; i < 100; ++i) scene.tick({hand});
      escaped += scene.last.f_T_W.z < 0.1;
    }
    state.counters[fmt::format("escaped_{:g}mm_percent", step_mm)] = 100.0 * escaped / hands;
  }
}

/// `anatomy`: null for a simple shape.
void add_subject(const std::string& name, const std::shared_ptr<Subject>& of, const Anatomy* anatomy, bool solid) {
  for (const std::string& model : haptics::contact_method_names()) {
    for (const Setting& s : settings_of(model, anatomy)) {
      const std::string at = fmt::format("/{}/{}/{}", name, s.model, s.knob);
      add("slide" + at, [=](auto& state) { follow(state, of->tissue(), of->slide(), s, true); });
      add("tap" + at, [=](auto& state) { follow(state, of->tissue(), test::tap_course(of->tissue()), s, false); });
      add("drag" + at, [=](auto& state) { drag(state, of->tissue(), of->slide(), s); });
      if (solid) add("drill" + at, [=](auto& state) { drill(state, of->tissue(), s); });
    }
    const Setting usual = default_setting(model);
    if (!solid)
      add(fmt::format("break-through/{}/{}", name, model),
          [=](auto& state) { break_through(state, of->tissue(), usual); });
  }
}

}  // namespace

void add_cases() {
  // The set-up time of a packing includes its computation, so no result of an earlier run is used.
  static const TemporaryFolder cache;
  setenv("TYPODONT_CACHE", cache.path().c_str(), 1);
  for (const ModelTissue& tissue : test::analytic_tissues()) {
    if (smoke() && tissue.name != "ball") continue;
    add_subject(tissue.name, std::make_shared<Subject>(Subject{[tissue] { return tissue; }}), nullptr, tissue.solid);
  }
  const auto ball = std::make_shared<Subject>(Subject{[] { return test::analytic_tissues().front(); }});
  for (const auto& [knob, json] : std::initializer_list<std::pair<const char*, const char*>>{
           {"every tick", R"("offset")"},
           {"30 Hz blended", R"({"offset": {"intermediate_surface": {}}})"},
           {"30 Hz at once", R"({"offset": {"intermediate_surface": {"mm3_per_N_s": 1e6, "max_mm_per_s": 1e4}}})"}})
    add(fmt::format("surface/ball/offset/{}", knob), [=](auto& state) { follow_surface(state, ball->tissue(), json); });
  if (smoke()) return;
  test::Random random(1);
  for (const test::PressCase& c : test::all_press_cases(random)) {
    for (const std::string& model : haptics::contact_method_names()) {
      const Setting s = default_setting(model);
      add(fmt::format("press/{}/{}/{}", c.name, model, s.knob),
          [=](auto& state) { report(state, test::press_ball(c, s.voxel_mm * kMillimetre, s.method)); });
    }
  }
  for (const Anatomy& anatomy : anatomies()) {
    const auto subject = std::make_shared<Subject>(Subject{[anatomy] { return load_anatomy(anatomy); }});
    add_subject(anatomy.name, subject, &anatomy, true);
  }
  for (const double thickness_mm : {0.2, 0.5, 1.0})
    for (const std::string& model : haptics::contact_method_names())
      add(fmt::format("escape/sheet of {:g} mm/{}", thickness_mm, model),
          [=](auto& state) { escape(state, thickness_mm, default_setting(model)); });
}

}  // namespace typodont::bench
