// Contact and cutting of the default model, with the methods of other programs on the same tissue and hand.
#include <functional>
#include <map>
#include <memory>

#include "engine/app/assets.h"
#include "engine/base/voxels.h"
#include "haptics/soft_tissue.h"
#include "haptics/tissue_volume.h"
#include "tests/bench/haptic_scene.h"
#include "tests/bench/level_set.h"
#include "tests/bench/model_cases.h"
#include "tests/bench/offset_mesh.h"
#include "tests/bench/press_report.h"
#include "tests/support/sliding_hand.h"

namespace typodont::bench {

namespace {

using haptics::HeadShape;
using haptics::ServoSettings;

/// Returns the position of a hand that slides on a ball: 0.4 mm deep, on an oblique great circle, at 20 mm/s.
dvec3 sliding(int tick, double radius) {
  const double angle = 0.02 * 1e-3 * tick / radius + 0.3;
  const dvec3 u = glm::normalize(dvec3(1, 0.3, 0.2)), v = glm::normalize(glm::cross(u, dvec3(0.2, -0.1, 1)));
  return (radius - 4e-4) * (std::cos(angle) * u + std::sin(angle) * v);
}
constexpr int kApproach = 50;     // ticks until the force has risen
constexpr double kHead = 0.6e-3;  // m, radius of the head that slides
constexpr double kPath = kBallRadius + kHead;
constexpr double kScanStep = 0.2;  // N, limit for force steps on a scanned tooth
constexpr double kScanTick = 1e6;  // ns, limit of the 99.9 % quantile there

/// Computes the direction of the force of one tick at a hand's position.
using Direction = std::function<dvec3(const dvec3& hand)>;

/// Slides on the ball. Ticks are timed in batches of 20, because reading the clock takes as long as a tick. `start`
/// begins a new slide; `prepare`, which is not timed, runs before each batch. Returns the largest angle between force
/// and normal, degrees.
double slide(
    benchmark::State& state, const std::function<Direction()>& start,
    const std::function<void(const dvec3&)>& prepare = [](const dvec3&) {}) {
  constexpr int kBatch = 20;
  double worst = 0;
  const std::vector<double> times = least_of([&] {
    const Direction direction = start();
    std::vector<double> run;
    for (int first = 0; first + kBatch <= (smoke() ? 200 : 2000); first += kBatch) {
      dvec3 p[kBatch], f[kBatch];
      for (int k = 0; k < kBatch; ++k) p[k] = sliding(first + k, kPath);
      prepare(p[0]);
      const Nanos before = thread_cpu_time();
      for (int k = 0; k < kBatch; ++k) f[k] = direction(p[k]);
      run.push_back(static_cast<double>(thread_cpu_time() - before) / kBatch);
      for (int k = 0; k < kBatch; ++k)
        if (first + k > kApproach) worst = std::max(worst, degrees_between(f[k], p[k]));
    }
    return run;
  });
  set_time(state, quantile(times, 0.5));
  state.counters["direction_max_deg"] = worst;
  return worst;
}

ServoSettings probe(const std::string& model) {
  ServoSettings settings;
  settings.tool = round_head(2 * kHead);
  settings.method = haptics::contact_method(model, "bench");
  // Friction would change the direction of the force, which is measured.
  settings.friction = settings.cutting = false;
  settings.damping = 0;
  return settings;
}

double slide_with(benchmark::State& state, const std::string& model, double voxel_mm) {
  const haptics::DenseTissue dense = tissue(kBall, voxel_mm);
  std::unique_ptr<test::HapticBench> scene;
  const auto begin = [&] {
    scene.reset(new test::HapticBench(haptics::TissueVolume(dense), probe(model), even_materials()));
    scene->tick({1.1 * sliding(0, kPath)});
  };
  const double worst = slide(
      state,
      [&]() -> Direction {
        begin();
        return [&](const dvec3& p) {
          scene->servo.tick({scene->t += 1'000'000, {p}, 0}, scene->last, scene->cut);
          return scene->last.f_T_W;
        };
      },
      [&](const dvec3& p) {
        scene->last.X_WT.p = p;
        if (!scene->carver.snapshot_due(scene->last)) return;
        scene->steps.take_snapshot(scene->carver.snapshot_center(scene->last));
        scene->steps.adopt_snapshot();
      });
  state.counters["slow_ns"] = quantile(least_of([&] {
                                         begin();
                                         return servo_times(*scene, 0, smoke() ? 200 : 2000,
                                                            [](int i, const auto&) { return Pose{sliding(i, kPath)}; });
                                       }),
                                       0.999);
  return worst;
}

void add_slides(double voxel_mm) {
  const std::string at = fmt::format("/voxel {:g} mm", voxel_mm);
  // The first case stores its error, which the second one compares.
  const auto ours = std::make_shared<double>(0);
  add("slide/offset" + at, [=](benchmark::State& state) { *ours = slide_with(state, "offset", voxel_mm); });
  add("slide/voxel_penalty" + at, [=](benchmark::State& state) {
    const double theirs = slide_with(state, "voxel_penalty", voxel_mm);
    if (voxel_mm < 0.15)
      require(*ours < 1e-4 * theirs, "the direction of `offset` is four orders better than that of voxel penalty");
  });
  add("slide/penalty with OpenVDB" + at, [=](benchmark::State& state) {
    const LevelSet field(tissue(kBall, voxel_mm), 8);
    slide(state, [&]() -> Direction { return [&](const dvec3& p) { return field.push(p, kHead) - p; }; });
  });
  for (const double edge_mm : {0.25, 0.12}) {
    if (voxel_mm != 0.1) continue;  // a mesh has no voxels
    add(fmt::format("slide/proxy on the offset mesh/edge {:g} mm", edge_mm), [=](benchmark::State& state) {
      OffsetMesh mesh(kPath, edge_mm * kMillimetre);
      slide(state, [&]() -> Direction {
        mesh.place(1.1 * sliding(0, kPath));
        return [&](const dvec3& p) { return mesh.follow(p); };
      });
    });
  }
}

/// Presses a ball where a trainee works: on edges, rims, corners, cusps and thin walls.
void add_presses(double voxel_mm) {
  const auto add_press = [voxel_mm](const std::string& name, std::function<test::PressErrors(double)> press) {
    add(fmt::format("press/{}/voxel {:g} mm", name, voxel_mm), [=](benchmark::State& state) {
      const test::PressErrors errors = press(voxel_mm * kMillimetre);
      report(state, errors);
      require(errors.median_direction() < 0.2 && test::PressErrors::quantile(errors.direction, 1) < 2,
              "at rims, edges, corners and cusps, the direction is right to 0.2 degrees, and to 2 at worst: " + name);
    });
  };
  test::Random random(1);
  for (const test::PressCase& c : test::all_press_cases(random))
    add_press(c.name, [c](double voxel) { return test::press_ball(c, voxel); });
  add_press("rim of a bore that a bur drilled", [](double voxel) {
    test::Random places(1);
    return test::press_drilled_rim(places, voxel);
  });
  add_press("rim of a filling", [](double voxel) {
    test::Random places(1);
    return test::press_filled_rim(places, voxel);
  });
}

/// A tool slides on a scanned tooth, 0.1 mm below where it rests. The force changes at most by twice the stiffness
/// times the hand's motion, because the tissue is smooth at this depth; more is a step.
void slide_on_scan(benchmark::State& state, const std::string& scan, const std::string& tool, double rate) {
  static std::map<std::string, test::ModelTissue> scans;
  if (!scans.contains(scan)) scans.emplace(scan, load_anatomy({scan.c_str(), {0.2}}));
  ServoSettings settings = probe("offset");
  settings.tool = haptics::read_tool(Json::load(assets_folder() / "tools" / (tool + ".json")));
  settings.passivity = settings.boundary_walls = false;
  settings.tick = 1 / rate;
  test::HapticBench bench = scene_of(scans.at(scan).make(0.2), settings);
  test::SlidingHand hand;
  hand.center = scans.at(scan).start;
  hand.R = glm::angleAxis(0.3, dvec3(0.6, 0.8, 0));
  bench.tick({hand.center + dvec3(0, 0, 2 * settings.tool.reach()), hand.R});
  const test::SlideResult result = test::slide(bench, hand, smoke() ? 0.1 : 3, 2);
  set_times(state, result.times);
  state.counters["step_beyond_motion_N"] = result.step_beyond_motion;
  require(result.step_beyond_motion < kScanStep, fmt::format("{} on the {} steps by {:.3f} N at {:g} Hz, limit {} N",
                                                             tool, scan, result.step_beyond_motion, rate, kScanStep));
  require_time(quantile(result.times, 0.999) < kScanTick, "a tick on a tooth takes less than its period: " + tool);
}

/// A ball slides around the rim of a bore at 20 mm/s, 0.2 mm deep, and tilts across the rim. Times are those of every
/// tick.
void slide_on_rim(benchmark::State& state, double voxel_mm) {
  constexpr double kRim = 1e-3;  // m, radius of the bore
  const dvec3 center(0, 0, std::sqrt(kBallRadius * kBallRadius - kRim * kRim));
  const auto normal = [&](int tick) {
    const double around = 0.02 * 1e-3 * tick / kRim, tilt = 0.5 * std::sin(3e-3 * tick) - 0.5;
    return dvec3(std::sin(tilt) * std::cos(around), std::sin(tilt) * std::sin(around), std::cos(tilt));
  };
  std::vector<double> errors;
  set_times(state, least_of([&] {
              errors.clear();
              test::HapticBench scene = scene_of(haptics::TissueVolume(tissue(kBore, voxel_mm)), probe("offset"));
              const std::vector<double> times =
                  servo_times(scene, 0, smoke() ? 200 : 5000, [&](int i, const auto& last) {
                    if (i > kApproach) errors.push_back(degrees_between(last.f_T_W, normal(i - 1)));
                    const double around = 0.02 * 1e-3 * i / kRim;
                    const dvec3 rim = center + kRim * dvec3(std::cos(around), std::sin(around), 0);
                    return Pose{rim + (kHead - 2e-4 + 1e-3 * std::max(0.0, 1 - i / 40.0)) * normal(i)};
                  });
              return std::vector<double>(times.begin() + kApproach, times.end());
            }));
  state.counters["direction_median_deg"] = quantile(errors, 0.5);
  state.counters["direction_max_deg"] = quantile(errors, 1);
}

/// A query of the field: its time, and the error of its direction.
template <class Sample>
double query(benchmark::State& state, double voxel_mm, Sample sample) {
  test::HapticBench scene = scene_of(haptics::TissueVolume(tissue(kBall, voxel_mm)), probe("offset"));
  scene.tick({sliding(0, kPath)});
  const haptics::TissuePatch& patch = scene.patch();
  const VoxelFrame& frame = scene.settings.frame;
  std::vector<dvec3> points;
  for (int i = 0; i < 256; ++i)
    points.push_back(frame.to_voxels(patch.center_W) +
                     2.0 * dvec3(std::sin(1.1 * i), std::sin(1.7 * i), std::sin(2.3 * i)));
  double worst = 0, sum = 0;
  for (const dvec3& p : points) worst = std::max(worst, degrees_between(sample(patch, p).gradient, frame.to_world(p)));
  set_time(state, batch_ns(51, 256, [&](int k) { sum += sample(patch, points[static_cast<std::size_t>(k)]).value; }));
  state.counters["direction_max_deg"] = std::isfinite(sum) ? worst : std::nan("");
  return worst;
}

/// The hand of a trainee that drills a block: a mass of 0.15 kg that presses with 1 N, swings the bur through the
/// tissue by ±1.5 mm at 1 Hz, tilts it by up to 10° and trembles at 9 Hz.
class TraineeHand {
 public:
  explicit TraineeHand(const haptics::Tool& tool) : x_(0, 0, kBlockTop + tool.half() + 2e-5) {}
  Pose next(const dvec3& force, double dt) {
    const double tremor = 5e-5 * std::sin(2 * kPi * 9 * t_);
    const dvec3 goal(1.5e-3 * std::sin(2 * kPi * t_) + tremor, 0.7e-3 * std::sin(2 * kPi * 0.63 * t_), 0);
    const dvec3 pull(2000 * (goal.x - x_.x), 2000 * (goal.y - x_.y), -1 + 2000 * tremor);
    v_ += dt * (pull - 5.0 * v_ + force) / 0.15;
    x_ += dt * v_;
    t_ += dt;
    return {x_, glm::angleAxis(10 * kDegree * std::sin(2 * kPi * 0.4 * t_), dvec3(0.6, 0.8, 0))};
  }

 private:
  dvec3 x_, v_{0};
  double t_ = 0;
};

/// A trainee drills a block. The times are those of every tick, as a session records them.
void drill(benchmark::State& state, const haptics::Tool& tool, double voxel_mm) {
  ServoSettings settings;
  settings.tool = tool;
  settings.spindle.free_speed = 300 * kKrpm;
  test::HapticBench scene = scene_of(haptics::TissueVolume(tissue(kBlock, voxel_mm)), settings);
  const double whole = total(scene.carver.volume().volumes());
  TraineeHand hand(tool);
  double work = 0;
  const int ticks = smoke() ? 300 : 6000;
  const Nanos start = thread_cpu_time();
  const std::vector<double> times = servo_times(scene, 1, ticks, [&](int, const ServoTick& last) {
    work += last.cutting_power * settings.tick;
    return hand.next(last.f_T_W, settings.tick);
  });
  state.counters["process_ns"] = static_cast<double>(thread_cpu_time() - start) / ticks;
  work += scene.last.cutting_power * settings.tick;
  const double removed = whole - total(scene.carver.volume().volumes());
  set_times(state, times);
  state.counters["removed_mm3"] = removed / kCubicMillimetre;
  state.counters["energy_error_rel"] = std::abs(work / kSpecificEnergy / removed - 1);
  require(std::abs(work / kSpecificEnergy / removed - 1) < 1e-6, "the motor's work equals that of the removed volume");
}

/// Volume and time of a stroke of a ball through the top of the block. `volume` returns the present volume, `cut` moves
/// the ball to its next position. Returns the relative error of the removed volume.
double stroke(benchmark::State& state, const std::function<double()>& volume,
              const std::function<void(const dvec3& from, const dvec3& to)>& cut) {
  constexpr int kSteps = 20;
  constexpr double r = kHead, depth = 0.43e-3, length = 1e-3;
  const auto at = [&](int i) {
    return dvec3(-0.513e-3 + length * std::clamp(i, 0, kSteps) / kSteps, 0.027e-3, kBlockTop + r - depth);
  };
  // A circular segment along the path, and half a spherical cap at each end.
  const double segment = r * r * std::acos((r - depth) / r) - (r - depth) * std::sqrt(2 * r * depth - depth * depth);
  const double exact = segment * length + kPi * depth * depth * (r - depth / 3);
  const double before = volume();
  std::vector<double> times;
  for (int i = 0; i <= kSteps; ++i) {
    const Nanos start = thread_cpu_time();
    cut(at(i - 1), at(i));
    times.push_back(static_cast<double>(thread_cpu_time() - start));
  }
  const double error = std::abs((before - volume()) / exact - 1);
  set_time(state, quantile(times, 0.5));
  state.counters["volume_error_percent"] = 100 * error;
  return error;
}

/// Removes all voxels within the ball, as programs with voxels do.
void clear_voxels(haptics::DenseTissue& dense, const dvec3& center_W) {
  const dvec3 c = dense.frame.to_voxels(center_W);
  const double reach = kHead / dense.frame.voxel;
  const glm::ivec3 lo = glm::max(glm::ivec3(glm::ceil(c - reach)), 0),
                   hi = glm::min(glm::ivec3(glm::floor(c + reach)), dense.size - 1);
  for_each_voxel_between(lo, hi, [&](int x, int y, int z) {
    if (glm::distance(c, dvec3(x, y, z)) <= reach) dense.distance[dense.at(x, y, z)] = 1;
  });
}

void add_removals(double voxel_mm) {
  const std::string at = fmt::format("/voxel {:g} mm", voxel_mm);
  const auto ours = std::make_shared<double>(0);
  add("removal/sweep" + at, [=](benchmark::State& state) {
    haptics::TissueVolume volume(tissue(kBlock, voxel_mm));
    *ours = stroke(
        state, [&] { return total(volume.volumes()); },
        [&, first = true](const dvec3& from, const dvec3& to) mutable {
          volume.carve(
              haptics::Sweep(round_head(2 * kHead), {from}, {to}, volume.frame(), !std::exchange(first, false)));
        });
  });
  add("removal/csgDifference of OpenVDB" + at, [=](benchmark::State& state) {
    LevelSet field(tissue(kBlock, voxel_mm), 3);
    const double theirs = stroke(
        state, [&] { return field.volume(); }, [&](const dvec3&, const dvec3& to) { field.cut_ball(to, kHead); });
    require(*ours < theirs, "a sweep has less error than a difference of level sets" + at);
  });
  add("removal/voxels cleared" + at, [=](benchmark::State& state) {
    haptics::DenseTissue dense = tissue(kBlock, voxel_mm);
    stroke(
        state,
        [&] {
          return std::pow(dense.frame.voxel, 3) *
                 static_cast<double>(
                     std::count_if(dense.distance.begin(), dense.distance.end(), [](float d) { return d < 0; }));
        },
        [&](const dvec3&, const dvec3& to) { clear_voxels(dense, to); });
  });
}

void free_air(benchmark::State& state) {
  ServoSettings settings;
  settings.tool = round_head(1.2e-3);
  test::HapticBench scene = scene_of(haptics::TissueVolume(tissue(kBlock, 0.1)), settings);
  const dvec3 above(0, 0, kBlockTop + 2e-3);
  scene.tick({above});
  set_time(state, batch_ns(20, 256, [&](int k) {
             scene.servo.tick({scene.t += 1'000'000, {above + dvec3(1e-6 * k, 0, 0)}, 0}, scene.last, scene.cut);
           }));
}

/// The soft layer alone: a ball presses 0.6 mm deep and slides on a circle. `cutting`: m/s, see SoftTissue::Input.
void soft(benchmark::State& state, double cutting) {
  const std::vector<haptics::Tool> tools{round_head(1.2e-3)};
  const auto surface = std::make_shared<const haptics::SoftSurface>(
      haptics::SoftLaw{}, dvec3(-6e-3, -6e-3, -1e-3), dvec3(6e-3, 6e-3, 1e-3), [](const dvec3& p) { return p.z; });
  const int sinking = 600, ticks = smoke() ? 900 : 2600;
  set_times(state, least_of([&] {
              haptics::SoftTissue soft(surface, tools, 1000);
              std::vector<double> times;
              for (int i = 0; i < ticks; ++i) {
                const double angle = 2e-3 * i;  // at 2 mm/s
                const dvec3 p(1e-3 * std::cos(angle), 1e-3 * std::sin(angle), 0.6e-3 - 1e-6 * std::min(i, sinking));
                const Nanos start = thread_cpu_time();
                soft.tick({i * Nanos(1'000'000), 1e-3, {p}, 0, cutting});
                if (i >= sinking) times.push_back(static_cast<double>(thread_cpu_time() - start));
              }
              return times;
            }));
}

}  // namespace

void add_cases() {
  for (const double voxel_mm : {0.2, 0.1, 0.05}) {
    add_slides(voxel_mm);
    add_removals(voxel_mm);
    add(fmt::format("slide on a rim/voxel {:g} mm", voxel_mm),
        [=](benchmark::State& state) { slide_on_rim(state, voxel_mm); });
    if (voxel_mm < 0.15) add_presses(voxel_mm);
  }
  for (const std::string scan : {"molar", "arch"}) {
    for (const std::string tool : {"round_006", "round_012", "flame_012", "cylinder_012", "explorer"}) {
      for (const double rate : {1000.0, 4000.0})
        add(fmt::format("slide on a scan/{}/{}/{:g} Hz", scan, tool, rate),
            [=](benchmark::State& state) { slide_on_scan(state, scan, tool, rate); });
    }
    if (smoke()) break;
  }
  const auto linear = std::make_shared<double>(0);
  add("query/trilinear/voxel 0.1 mm",
      [=](benchmark::State& state) { *linear = query(state, 0.1, haptics::sample_linear_gradient); });
  add("query/cubic/voxel 0.1 mm", [=](benchmark::State& state) {
    require(query(state, 0.1, haptics::sample_cubic) < 1e-3 * *linear, "cubic is a thousand times better than linear");
  });
  const std::pair<const char*, haptics::Tool> heads[] = {{"round 1.2 mm", round_head(1.2e-3)},
                                                         {"round 4 mm", round_head(4e-3)},
                                                         {"flame 1.2 x 4 mm", head(HeadShape::kFlame, 1.2e-3, 4e-3)},
                                                         {"cylinder 1 x 4 mm", head(HeadShape::kCylinder, 1e-3, 4e-3)}};
  for (const double voxel_mm : {0.1, 0.05})
    for (const auto& [name, tool] : heads)
      add(fmt::format("drill/{}/voxel {:g} mm", name, voxel_mm),
          [=](benchmark::State& state) { drill(state, tool, voxel_mm); });
  add("free air", free_air);
  add("soft gum/a ball presses", [](benchmark::State& state) { soft(state, 0); });
  add("soft gum/a bur cuts", [](benchmark::State& state) { soft(state, 3); });
}

}  // namespace typodont::bench
