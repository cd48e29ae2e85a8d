#include "haptics/bench.h"

#include <fmt/format.h>
#include <pthread.h>
#include <sched.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <functional>
#include <memory>
#include <span>
#include <string_view>
#include <thread>
#include <utility>

#include "engine/base/dispatch.h"
#include "engine/base/measure.h"
#include "engine/base/units.h"
#include "haptics/carver.h"
#include "haptics/cut_front.h"
#include "haptics/lanes.h"
#include "haptics/servo.h"
#include "haptics/solid.h"
#include "haptics/volume/csg_baseline.h"

namespace typodont::haptics {

namespace {

/// CPU time of one call, ns: the median of `repeats` batches, because one call is too short for the clock.
template <class F>
double batch_ns(int repeats, int batch, F&& work) {
  std::vector<double> times;
  for (int i = 0; i < repeats; ++i) {
    const Nanos start = thread_cpu_time();
    for (int k = 0; k < batch; ++k) work(k);
    times.push_back(static_cast<double>(thread_cpu_time() - start) / batch);
  }
  return quantile(times, 0.5);
}

/// What reading the clock twice costs, ns: taken off every single time.
double clock_ns() {
  std::vector<double> times;
  for (int i = 0; i < 1001; ++i) {
    const Nanos start = thread_cpu_time();
    times.push_back(static_cast<double>(thread_cpu_time() - start));
  }
  return quantile(times, 0.5);
}

/// Equal runs do equal work, so the least time of each tick over a few runs is the tick's own, interrupts left out.
constexpr int kRuns = 3;
template <class Run>  // returns the times of its ticks, ns
std::vector<double> least_of(Run&& run) {
  const double clock = clock_ns();
  std::vector<double> least = run();
  for (int i = 1; i < kRuns; ++i) {
    const std::vector<double> more = run();
    for (std::size_t k = 0; k < least.size(); ++k) least[k] = std::min(least[k], more[k]);
  }
  for (double& time : least) time = std::max(time - clock, 0.0);
  return least;
}

DenseTissue tissue(std::string_view solids, double voxel_mm) {
  return read_solids(Json::parse(fmt::format(R"({{"voxel_mm": {:g}, "solids": {}}})", voxel_mm, solids), "bench"));
}

constexpr std::string_view kBall = R"([{"tissue": "enamel", "solid": {"sphere": {"radius_mm": 4}}}])";
constexpr std::string_view kBlock = R"([{"tissue": "dentin", "solid": {"box": {"size_mm": [6, 6, 4]}}}])";
constexpr double kBallRadius = 4e-3, kBlockTop = 2e-3;  // m

Tool head(HeadShape shape, double diameter, double length) {
  Tool tool;
  tool.shape = shape;
  tool.diameter = diameter;
  tool.length = length;
  return tool;
}

/// The carver's thread while it cuts out patches. As in a session it works on another core, where there is one: what it reads
/// and writes then does not drive the servo's code and data out of its caches.
class OtherThread {
 public:
  OtherThread() : thread_([this] { loop(); }) {
    cpu_set_t cores;
    CPU_ZERO(&cores);
    pthread_getaffinity_np(pthread_self(), sizeof cores, &cores);
    const int here = sched_getcpu();
    if (CPU_COUNT(&cores) < 2 || here < 0) return;
    CPU_CLR(here, &cores);
    pthread_setaffinity_np(thread_.native_handle(), sizeof cores, &cores);
  }
  ~OtherThread() {
    work_ = nullptr;
    hand_over();
    thread_.join();
  }
  OtherThread(const OtherThread&) = delete;
  OtherThread& operator=(const OtherThread&) = delete;

  /// Returns when it is done.
  void run(std::function<void()> work) {
    work_ = std::move(work);
    hand_over();
    busy_.wait(true, std::memory_order_acquire);
  }

 private:
  void hand_over() {
    busy_.store(true, std::memory_order_release);
    busy_.notify_one();
  }
  void loop() {
    for (;;) {
      busy_.wait(false, std::memory_order_acquire);
      if (!work_) return;
      work_();
      busy_.store(false, std::memory_order_release);
      busy_.notify_one();
    }
  }

  std::atomic<bool> busy_{false};
  std::function<void()> work_;
  std::thread thread_;
};

/// Servo and carver in lock-step, as in the program's deterministic loop.
struct Scene {
  ServoSettings settings;
  Carver carver;
  Servo servo;
  SurfacePatch spare;
  ServoTick last;
  Cut cut;
  Nanos t = 0;
  OtherThread carving;

  Scene(const DenseTissue& dense, ServoSettings s)
      : settings(with_tissue(std::move(s), dense)),
        carver(TissueVolume(dense), tray(settings)),
        servo(settings, patch_edge_for(tray(settings), settings.frame.voxel)) {
    spare.resize(servo.patch().n);
  }

  static ServoSettings with_tissue(ServoSettings s, const DenseTissue& dense) {
    s.frame = dense.frame;
    for (Material& material : s.materials) material = {1000, 8e9, 0.2, 0.15, 2150, dvec3(0.8)};
    return s;
  }

  /// One tick; returns its CPU time, ns.
  double tick(const Pose& X_WT, double pedal) {
    if (t == 0) last.X_WT = last.X_WG = X_WT;
    if (carver.patch_due(last)) {
      carving.run([&] { carver.cut_out(carver.patch_center(last), spare); });
      servo.adopt(spare);
    }
    const Nanos start = thread_cpu_time();
    const bool cuts = servo.tick({t, X_WT, pedal}, last, cut);
    const double time = static_cast<double>(thread_cpu_time() - start);
    if (cuts) carver.apply(cut);
    t += from_seconds(settings.tick);
    return time;
  }
};

double degrees_between(const dvec3& a, const dvec3& b) {
  return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b)) * 180 / kPi;
}

/// Where a hand slides on a ball: 0.4 mm deep, around it askew, 20 mm/s.
dvec3 sliding(int tick, double radius) {
  const double angle = 0.02 * 1e-3 * tick / radius + 0.3;
  const dvec3 u = glm::normalize(dvec3(1, 0.3, 0.2)), v = glm::normalize(glm::cross(u, dvec3(0.2, -0.1, 1)));
  return (radius - 4e-4) * (std::cos(angle) * u + std::sin(angle) * v);
}

/// Voxel probing as in CHAI3D's volume objects with a finger proxy (Ruspini 1997): a voxel is full or empty, the proxy
/// marches in half voxels until the head meets a full one, the normal is where the empty space around it lies, and the
/// rest of the way goes along the plane.
class VoxelProbe {
 public:
  VoxelProbe(const DenseTissue& dense, double radius, const dvec3& start)
      : frame_(dense.frame), size_(dense.size), radius_(radius / dense.frame.voxel), c_(frame_.to_voxels(start)) {
    for (const float d : dense.distance) full_.push_back(d < 0);
  }

  /// Direction in which the hand at p_WT is pushed; 0 when it is free.
  dvec3 push(const dvec3& p_WT) {
    const dvec3 goal = frame_.to_voxels(p_WT);
    dvec3 aim = goal;
    for (int plane = 0; plane < 3; ++plane) {
      if (!march(aim)) break;
      dvec3 n;
      probe(c_, radius_ + 1, &n);
      const double below = glm::dot(goal - c_, n);
      if (below >= 0) break;
      aim = goal + (0.5 - below) * n;  // half a voxel off the plane: a proxy that rests on full voxels sticks to them
    }
    return c_ - goal;
  }

 private:
  bool probe(const dvec3& c, double radius, dvec3* n) const {
    const glm::ivec3 lo = glm::max(glm::ivec3(glm::ceil(c - radius)), 0);
    const glm::ivec3 hi = glm::min(glm::ivec3(glm::floor(c + radius)), size_ - 1);
    dvec3 sum(0);
    bool hit = false;
    for (int x = lo.x; x <= hi.x; ++x) {
      for (int y = lo.y; y <= hi.y; ++y) {
        for (int z = lo.z; z <= hi.z; ++z) {
          if (!full_[(static_cast<std::size_t>(x) * size_.y + y) * size_.z + z]) continue;
          const dvec3 d = c - dvec3(x, y, z);
          if (glm::dot(d, d) > radius * radius) continue;
          if (!n) return true;
          hit = true;
          sum += d;
        }
      }
    }
    if (n) *n = hit ? glm::normalize(sum) : dvec3(0);
    return hit;
  }
  /// Half voxels toward `aim` until the head meets tissue; true when it did.
  bool march(const dvec3& aim) {
    const dvec3 way = aim - c_;
    const int steps = static_cast<int>(std::ceil(2 * glm::length(way)));
    const dvec3 from = c_;
    for (int i = 1; i <= steps; ++i) {
      const dvec3 next = from + way * (static_cast<double>(i) / steps);
      if (probe(next, radius_, nullptr)) return true;
      c_ = next;
    }
    return false;
  }

  VoxelFrame frame_;
  glm::ivec3 size_;
  double radius_;
  dvec3 c_;
  std::vector<char> full_;
};

/// Adds up 6 × 6 rows of eight samples, six sums side by side, so that no addition waits for the one before.
TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
void scan_rows(const float* corner, std::size_t edge, float* sum) {
  F8 sums[6] = {};
  for (std::size_t i = 0; i < 6; ++i) {
    for (std::size_t j = 0; j < 6; ++j) sums[j] += *reinterpret_cast<const F8*>(corner + (i * edge + j) * edge);
  }
  *sum += sum_of(((sums[0] + sums[1]) + (sums[2] + sums[3])) + (sums[4] + sums[5]));
}

void slide_rows(const BenchOptions& options, std::vector<BenchRow>& rows) {
  for (const double voxel_mm : options.voxels_mm) {
    const std::string knob = fmt::format("voxel {:g} mm", voxel_mm);
    const DenseTissue dense = tissue(kBall, voxel_mm);
    ServoSettings settings;
    settings.tool = head(HeadShape::kSphere, 1.2e-3, 1.2e-3);
    settings.friction = false;  // it would tilt the force
    settings.damping = 0;
    settings.cutting = false;
    const double radius = kBallRadius + settings.tool.radius();
    const dvec3 outside = 1.1 * sliding(0, radius);

    VoxelProbe probe(dense, settings.tool.radius(), outside);
    const double clock = clock_ns();
    double probe_error = 0;
    std::vector<double> times;
    for (int i = 0; i < options.ticks; ++i) {
      const dvec3 p = sliding(i, radius);
      const Nanos start = thread_cpu_time();
      const dvec3 push = probe.push(p);
      times.push_back(static_cast<double>(thread_cpu_time() - start) - clock);
      if (i > 50) probe_error = std::max(probe_error, degrees_between(push, p));
    }
    const double probe_ns = quantile(times, 0.5);
    rows.push_back(
        {"slide on a sphere, voxel probing", knob, probe_error, "degree, greatest", probe_ns, "tick"});

    // A god-object on the offset surface with one query a look, by either interpolation: what the order buys.
    const auto by_queries = [&](auto sample, const char* name) {
      Scene still(dense, settings);
      double error = 0;
      const std::vector<double> ticks = least_of([&] {
        std::vector<double> run;
        dvec3 c = dense.frame.to_voxels(outside);
        error = 0;
        for (int i = 0; i < options.ticks; ++i) {
          const dvec3 p = sliding(i, radius), goal = dense.frame.to_voxels(p);
          still.last.X_WT.p = p, still.last.X_WG.p = dense.frame.to_world(c);
          if (still.carver.patch_due(still.last)) still.carver.cut_out(still.carver.patch_center(still.last), still.spare);
          const Nanos start = thread_cpu_time();
          for (int look = 0; look < 8; ++look) {
            const FieldSample at = sample(still.spare, c);
            const dvec3 n = glm::normalize(at.gradient);
            c = goal + n * (settings.tool.radius() / dense.frame.voxel - at.value + glm::dot(n, c - goal));
          }
          run.push_back(static_cast<double>(thread_cpu_time() - start));
          if (i > 50) error = std::max(error, degrees_between(c - goal, p));
        }
        return run;
      });
      const double ns = quantile(ticks, 0.5);
      rows.push_back({name, knob, error, "degree, greatest", ns, "tick", "voxel probing", ns / probe_ns});
    };
    by_queries(sample_linear_gradient, "slide on a sphere, eight trilinear looks");
    by_queries(sample_cubic, "slide on a sphere, eight cubic looks");

    double error = 0;
    times = least_of([&] {
      Scene scene(dense, settings);
      error = 0;
      std::vector<double> run;
      scene.tick({outside}, 0);
      for (int i = 0; i < options.ticks; ++i) {
        const dvec3 p = sliding(i, radius);
        run.push_back(scene.tick({p}, 0));
        if (i > 50) error = std::max(error, degrees_between(scene.last.f_T_W, p));  // the ramp and the approach are over
      }
      return run;
    });
    for (const auto& [name, share] :
         {std::pair{"slide on a sphere, median", 0.5}, {"slide on a sphere, 99.9 %", 0.999}}) {
      const double ns = quantile(times, share);
      rows.push_back({name, knob, error, "degree, greatest", ns, "tick", "voxel probing", ns / probe_ns});
    }
    Scene scene(dense, settings);
    scene.tick({sliding(0, radius)}, 0);

    // The queries alone, in batches, at the head's centre.
    const SurfacePatch& patch = scene.servo.patch();
    std::vector<dvec3> points;
    const dvec3 center = dense.frame.to_voxels(patch.center_W);
    for (int i = 0; i < 256; ++i)
      points.push_back(center + 2.0 * dvec3(std::sin(1.1 * i), std::sin(1.7 * i), std::sin(2.3 * i)));
    const auto query = [&](auto sample, const char* name, double linear_ns) {
      double worst = 0, sum = 0;
      for (const dvec3& p : points)
        worst = std::max(worst, degrees_between(sample(patch, p).gradient, dense.frame.to_world(p)));
      const double ns =
          batch_ns(51, 256, [&](int k) { sum += sample(patch, points[static_cast<std::size_t>(k)]).value; });
      if (!std::isfinite(sum)) worst = std::nan("");
      rows.push_back({name, knob, worst, "degree, greatest", ns, "query", linear_ns > 0 ? "trilinear" : "",
                      linear_ns > 0 ? ns / linear_ns : BenchRow::kNone});
      return ns;
    };
    const double linear_ns = query(sample_linear_gradient, "direction, trilinear", 0);
    const double cubic_ns = query(sample_cubic, "direction, cubic", linear_ns);

    // The floor of a query: the same 6 × 6 rows of samples read and added up, where the points are known beforehand.
    std::vector<const float*> corners;
    for (const dvec3& p : points) {
      const glm::ivec3 corner = glm::ivec3(p) - patch.lo - glm::ivec3(2, 2, 4);
      corners.push_back(patch.distance.data() + patch.at(corner.x, corner.y, corner.z));
    }
    float read = 0;
    const std::size_t edge = static_cast<std::size_t>(patch.n);
    const double scan_ns = batch_ns(51, 256, [&](int k) { scan_rows(corners[static_cast<std::size_t>(k)], edge, &read); });
    rows.push_back({"floor: scan of the samples a cubic query reads", knob, BenchRow::kNone, "", scan_ns, "query", "", BenchRow::kNone,
                    std::isfinite(read) ? 288.0 : 0.0, "samples"});
    rows.push_back({"direction, cubic, against the floor", knob, BenchRow::kNone, "", cubic_ns, "query", "the scan", cubic_ns / scan_ns});
  }
}

/// The samples that differ between two patches, as stretches along z.
struct Stretch {
  std::size_t from, count;
};
std::vector<Stretch> changed_stretches(const SurfacePatch& before, const SurfacePatch& after) {
  std::vector<Stretch> list;
  for (std::size_t i = 0; i < after.distance.size(); ++i) {
    if (after.distance[i] == before.distance[i]) continue;
    if (!list.empty() && list.back().from + list.back().count == i) {
      ++list.back().count;
    } else {
      list.push_back({i, 1});
    }
  }
  return list;
}

/// Reads and writes groups of samples, as wide as the processor takes them.
TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
void scan_groups(float* samples, const std::ptrdiff_t* from, std::size_t groups, int lanes, float least) {
  for (std::size_t g = 0; g < groups; ++g) {
    float* const group = samples + from[g];
    for (int half = 0; half < lanes; half += 8) {
      for (int i = half; i < half + 8; ++i) group[i] = std::max(group[i], least);
    }
  }
}

/// The cut of one tick by itself, beside two floors: reading and writing just the samples that it changes, and reading and
/// writing the same groups of samples as it does. Both known beforehand.
void cut_rows(const Tool& tool, const std::string& knob, const DenseTissue& dense, std::vector<BenchRow>& rows) {
  Carver carver(TissueVolume(dense), std::span(&tool, 1));
  SurfacePatch patch;
  patch.resize(patch_edge_for(std::span(&tool, 1), dense.frame.voxel));
  constexpr int kCycle = 34;  // cuts of 0.03 voxel, as in drilling, in which all that is listed is listed anew
  const double way = 0.03 * dense.frame.voxel;
  const auto at = [&](int i) {
    return Pose{dvec3(0, 0, kBlockTop + tool.length / 2 - 0.4e-3) + way * i * glm::normalize(dvec3(0.5, 0.2, -0.6))};
  };
  carver.cut_out(at(0).p, patch);
  CutFront front(std::span(&tool, 1), dense.frame.voxel);
  carve(patch, Sweep(tool, at(0), at(0), dense.frame), nullptr, &front);
  int step = 0;
  const auto cut_on = [&](int) {
    carve(patch, Sweep(tool, at(step), at(step + 1), dense.frame, true), nullptr, &front);
    ++step;
  };
  for (int i = 0; i < 2 * kCycle; ++i) cut_on(i);
  const SurfacePatch before = patch;
  cut_on(0);
  const std::vector<Stretch> stretches = changed_stretches(before, patch);
  const std::vector<std::ptrdiff_t> groups = front.listed_in(patch.lo, patch.n);
  double samples = 0;
  for (const Stretch& s : stretches) samples += static_cast<double>(s.count);
  const double scan = batch_ns(51, 16, [&](int k) {
    const float rise = 1e-9f * static_cast<float>(k);
    for (const Stretch& s : stretches) {
      for (std::size_t i = s.from; i < s.from + s.count; ++i) patch.distance[i] = std::max(patch.distance[i], rise - 9);
    }
  });
  const double same = batch_ns(51, 16, [&](int k) {
    scan_groups(patch.distance.data(), groups.data(), groups.size(), widest_group(), 1e-9f * static_cast<float>(k) - 9);
  });
  const double cut = batch_ns(5, kCycle, cut_on);
  const double lanes = static_cast<double>(groups.size()) * widest_group();
  rows.push_back({"floor: scan of the samples a cut changes", knob, BenchRow::kNone, "", scan, "cut", "", BenchRow::kNone,
                  samples, "samples"});
  rows.push_back({"floor: scan of the samples a cut reads and writes", knob, BenchRow::kNone, "", same, "cut", "", BenchRow::kNone,
                  lanes, "samples"});
  rows.push_back({"cut alone, 0.03 voxel", knob, BenchRow::kNone, "", cut, "cut", "the scan", cut / scan, samples, "samples"});
  rows.push_back({"cut alone, 0.03 voxel, by what it reads and writes", knob, BenchRow::kNone, "", cut, "cut", "that scan", cut / same,
                  lanes, "samples"});
}

/// A simulated hand (0.15 kg, 5 N·s/m) that pushes with 1 N and swings sideways.
class DrillingHand {
 public:
  explicit DrillingHand(const Tool& tool) : x_(0, 0, kBlockTop + tool.length / 2 + 2e-5) {}
  Pose next(const dvec3& force, double dt) {
    const double swing = 1e-3 * std::sin(2 * kPi * t_);
    v_ += dt * (dvec3(2000 * (swing - x_.x), -2000 * x_.y, -1) - 5.0 * v_ + force) / 0.15;
    x_ += dt * v_;
    t_ += dt;
    return {x_};
  }

 private:
  dvec3 x_, v_{0};
  double t_ = 0;
};

void drilling_rows(const BenchOptions& options, std::vector<BenchRow>& rows) {
  const double voxel_mm = *std::min_element(options.voxels_mm.begin(), options.voxels_mm.end());
  const DenseTissue dense = tissue(kBlock, voxel_mm);
  double whole = 0;
  for (const double volume : TissueVolume(dense).volumes()) whole += volume;
  const std::pair<const char*, Tool> heads[] = {{"round 1.2 mm", head(HeadShape::kSphere, 1.2e-3, 1.2e-3)},
                                                {"round 4 mm", head(HeadShape::kSphere, 4e-3, 4e-3)},
                                                {"flame 1.2 x 4 mm", head(HeadShape::kFlame, 1.2e-3, 4e-3)},
                                                {"cylinder 1 x 4 mm", head(HeadShape::kCylinder, 1e-3, 4e-3)}};
  for (const auto& named : heads) {
    const Tool& tool = named.second;
    const std::string knob = fmt::format("{}, voxel {:g} mm", named.first, voxel_mm);
    ServoSettings settings;
    settings.tool = tool;
    settings.spindle.free_speed = 300e3 / 60 * 2 * kPi;
    double error = 0;
    std::unique_ptr<Scene> last;
    const std::vector<double> ticks = least_of([&] {
      last = std::make_unique<Scene>(dense, settings);
      DrillingHand hand(tool);
      std::vector<double> run;
      double work = 0;
      for (int i = 0; i < options.ticks; ++i) {
        run.push_back(last->tick(hand.next(last->last.f_T_W, settings.tick), 1));
        work += last->last.cutting_power * settings.tick;
      }
      double left = 0;
      for (const double volume : last->carver.volume().volumes()) left += volume;
      // The servo's ledger against the volume that the carver holds: energy spent over specific energy.
      error = std::abs(work / 8e9 / (whole - left) - 1);
      return run;
    });
    Scene& scene = *last;
    rows.push_back(
        {"drilling tick, median", knob, error, "volume against energy", quantile(ticks, 0.5), "tick"});
    rows.push_back(
        {"drilling tick, 99.9 %", knob, error, "volume against energy", quantile(ticks, 0.999), "tick"});
    cut_rows(tool, knob, dense, rows);

    SurfacePatch fresh = scene.servo.patch();
    scene.carver.cut_out(scene.last.X_WG.p, fresh);
    rows.push_back({"patch cut-out", fmt::format("{0}, {1}³", knob, fresh.n), BenchRow::kNone, "",
                    batch_ns(21, 4, [&](int) { scene.carver.cut_out(scene.last.X_WG.p, fresh); }), "patch"});
    rows.push_back({"patch hand-over, nothing lacking", knob, BenchRow::kNone, "",
                    batch_ns(21, 64,
                             [&](int) {
                               fresh.cuts = scene.last.cuts;
                               scene.servo.adopt(fresh);
                             }),
                    "patch"});
    // As in a session (PatchExchange): cuts that are made while a patch is cut out the carver puts in …
    std::vector<double> kept_up, handed_over;
    const double clock = clock_ns();
    for (int i = 0; i < 9; ++i) {
      scene.carver.cut_out(scene.last.X_WG.p, fresh);
      scene.carver.remember_writes(true);
      const std::uint64_t wanted = scene.last.cuts + 16;
      for (int tick = 0; tick < 200 && scene.last.cuts < wanted; ++tick) {
        const Pose deeper{scene.last.X_WT.p - dvec3(0, 0, 1e-6), scene.last.X_WT.R};
        scene.t += from_seconds(settings.tick);
        if (scene.servo.tick({scene.t, deeper, 1}, scene.last, scene.cut)) scene.carver.apply(scene.cut);
      }
      scene.carving.run([&] {
        const Nanos start = thread_cpu_time();
        scene.carver.bring_up_to_date(fresh);
        kept_up.push_back(static_cast<double>(thread_cpu_time() - start) - clock);
      });
      thread_cpu_time();  // the clock itself is slow the first time after a wait
      const Nanos start = thread_cpu_time();
      scene.servo.adopt(fresh);
      handed_over.push_back(static_cast<double>(thread_cpu_time() - start) - clock);
      scene.carver.remember_writes(false);
    }
    rows.push_back({"16 cuts put into a patch by the carver", knob, BenchRow::kNone, "", quantile(kept_up, 0.5), "patch"});
    rows.push_back({"patch hand-over, 16 cuts made meanwhile", knob, BenchRow::kNone, "", std::max(quantile(handed_over, 0.5), 0.0), "patch"});
    // … unless it comes too late.
    scene.carver.cut_out(scene.last.X_WG.p, fresh);
    rows.push_back({"patch hand-over, 16 cuts put in by the servo", knob, BenchRow::kNone, "",
                    batch_ns(21, 64,
                             [&](int) {
                               fresh.cuts = scene.last.cuts - std::min<std::uint64_t>(scene.last.cuts, 16);
                               scene.servo.adopt(fresh);
                             }),
                    "patch"});
  }
}

/// A stroke of a ball along the surface, in steps: error of the volume, time per step.
void removal_rows(const BenchOptions& options, std::vector<BenchRow>& rows) {
  constexpr int kSteps = 20;
  const Tool tool = head(HeadShape::kSphere, 1.2e-3, 1.2e-3);
  const double r = tool.radius(), depth = 0.43e-3, length = 1e-3;
  const dvec3 a(-0.513e-3, 0.027e-3, kBlockTop + r - depth);
  const auto at = [&](int i) { return a + dvec3(length * i / kSteps, 0, 0); };
  // A circle's segment along the way, and half a cap at either end.
  const double segment = r * r * std::acos((r - depth) / r) - (r - depth) * std::sqrt(2 * r * depth - depth * depth);
  const double exact = segment * length + kPi * depth * depth * (r - depth / 3);
  for (const double voxel_mm : options.voxels_mm) {
    const std::string knob = fmt::format("voxel {:g} mm", voxel_mm);
    const DenseTissue dense = tissue(kBlock, voxel_mm);
    const auto run = [&](auto&& volume, auto&& cut) {
      const double before = volume();
      std::vector<double> times;
      for (int i = 0; i <= kSteps; ++i) {
        const Nanos start = thread_cpu_time();
        cut(i);
        times.push_back(static_cast<double>(thread_cpu_time() - start));
      }
      return std::pair{std::abs((before - volume()) / exact - 1), quantile(times, 0.5)};
    };
    CsgBaseline csg(dense);
    const auto [csg_error, csg_ns] = run([&] { return csg.volume(); }, [&](int i) { csg.cut_ball(at(i), r); });
    rows.push_back({"removal, OpenVDB csgDifference", knob, csg_error, "of the volume", csg_ns, "cut"});

    // Voxels cleared one by one, as CHAI3D's volume objects are drilled.
    std::vector<char> full;
    for (const float d : dense.distance) full.push_back(d < 0);
    const double voxel3 = std::pow(dense.frame.voxel, 3);
    const auto [clear_error, clear_ns] =
        run([&] { return voxel3 * static_cast<double>(std::count(full.begin(), full.end(), 1)); },
            [&](int i) {
              const dvec3 c = dense.frame.to_voxels(at(i));
              const double reach = r / dense.frame.voxel;
              const glm::ivec3 lo = glm::max(glm::ivec3(glm::ceil(c - reach)), 0);
              const glm::ivec3 hi = glm::min(glm::ivec3(glm::floor(c + reach)), dense.size - 1);
              for (int x = lo.x; x <= hi.x; ++x) {
                for (int y = lo.y; y <= hi.y; ++y) {
                  for (int z = lo.z; z <= hi.z; ++z) {
                    const dvec3 d = c - dvec3(x, y, z);
                    if (glm::dot(d, d) <= reach * reach) full[dense.at(x, y, z)] = 0;
                  }
                }
              }
            });
    rows.push_back({"removal, voxels cleared", knob, clear_error, "of the volume", clear_ns, "cut"});

    // In the servo's patch: what a tick pays.
    Carver carver(TissueVolume(dense), std::span(&tool, 1));
    SurfacePatch patch;
    patch.resize(2 * static_cast<int>(2e-3 / dense.frame.voxel) + 1);
    carver.cut_out(at(kSteps / 2), patch);
    double taken = 0;
    const auto [patch_error, patch_ns] = run([&] { return -taken; },
                                             [&](int i) {
                                               for (const double v : carve(patch, Sweep(tool, {at(std::max(i - 1, 0))}, {at(i)},
                                                                                        dense.frame, i > 0))) {
                                                 taken += v * voxel3;
                                               }
                                             });
    rows.push_back({"removal, sweep in the servo's patch", knob, patch_error, "of the volume", patch_ns, "cut",
                    "csgDifference", patch_ns / csg_ns});

    TissueVolume volume(dense);
    const auto sum = [&] {
      double all = 0;
      for (const double v : volume.volumes()) all += v;
      return all;
    };
    const auto [error, ns] =
        run(sum, [&](int i) { volume.carve(Sweep(tool, {at(std::max(i - 1, 0))}, {at(i)}, dense.frame, i > 0)); });
    rows.push_back({"removal, sweep", knob, error, "of the volume", ns, "cut", "csgDifference", ns / csg_ns});
  }
}

void free_air_row(const BenchOptions& options, std::vector<BenchRow>& rows) {
  ServoSettings settings;
  settings.tool = head(HeadShape::kSphere, 1.2e-3, 1.2e-3);
  Scene scene(tissue(kBlock, 0.1), settings);
  const dvec3 above(0, 0, kBlockTop + 2e-3);
  scene.tick({above}, 0);
  constexpr int kBatch = 256;
  std::vector<HandSample> way;  // known beforehand, as it is where a device brings it
  for (int k = 0; k < kBatch; ++k) way.push_back({0, {above + dvec3(1e-6 * k, 0, 0)}, 0});
  const double ns = batch_ns(std::max(options.ticks / 100, 5), kBatch, [&](int k) {
    HandSample& hand = way[static_cast<std::size_t>(k)];
    hand.t = scene.t += 1000000;
    scene.servo.tick(hand, scene.last, scene.cut);
  });
  rows.push_back({"free air, median", "round 1.2 mm", BenchRow::kNone, "", ns, "tick"});
}

/// Drilling at 10 kHz on the clock, while another thread keeps a second core busy: how many ticks end after the next
/// should have begun; or, not drilling, how many the machine misses by itself. As a session's servo does, the loop sleeps, then spins, and runs in front of others where it may.
void deadline_rows(const BenchOptions& options, bool drilling, std::vector<BenchRow>& rows) {
  constexpr Nanos kPeriod = 100'000, kSpin = 40'000;
  ServoSettings settings;
  settings.tool = head(HeadShape::kSphere, 1.2e-3, 1.2e-3);
  settings.spindle.free_speed = 300e3 / 60 * 2 * kPi;
  settings.tick = 1e-9 * kPeriod;
  Scene scene(tissue(kBlock, 0.1), settings);
  DrillingHand hand(settings.tool);
  scene.tick(hand.next(dvec3(0), settings.tick), 1);

  std::atomic<bool> stop{false};
  std::vector<double> late, busy_ticks;
  int missed = 0, ticks = 0;
  bool in_front = false;
  std::thread renderer([&] {
    std::vector<float> picture(1 << 20);
    for (float shade = 0; !stop.load(std::memory_order_relaxed); shade += 1) {
      for (float& pixel : picture) pixel = std::sqrt(pixel * 0.5f + shade);
    }
  });
  std::thread servo([&] {
    const sched_param priority{80};
    in_front = pthread_setschedparam(pthread_self(), SCHED_FIFO, &priority) == 0;
    const int wanted = 10 * options.ticks;
    Nanos next = now() + kPeriod;
    while (ticks < wanted) {
      if (const Nanos rest = next - now() - kSpin; rest > 0) std::this_thread::sleep_for(std::chrono::nanoseconds(rest));
      while (now() < next) {
      }
      scene.t += kPeriod;
      const Nanos start = thread_cpu_time();
      if (drilling) scene.servo.tick({scene.t, hand.next(scene.last.f_T_W, settings.tick), 1}, scene.last, scene.cut);
      busy_ticks.push_back(static_cast<double>(thread_cpu_time() - start));
      const Nanos end = now();
      late.push_back(static_cast<double>(end - next));
      ++ticks;
      next += kPeriod;
      for (; next < end; next += kPeriod) ++missed, ++ticks;  // those are lost
    }
  });
  servo.join();
  stop = true;
  renderer.join();
  const std::string knob = fmt::format("round 1.2 mm, voxel 0.1 mm, {}", in_front ? "SCHED_FIFO" : "ordinary priority");
  const double share = static_cast<double>(missed) / ticks;
  if (!drilling) {
    rows.push_back({"floor: 10 kHz beside a busy core, nothing done", knob, share, "of the deadlines missed", quantile(late, 0.5), "tick"});
    return;
  }
  rows.push_back({"drilling at 10 kHz beside a busy core, the tick", knob, share, "of the deadlines missed",
                  quantile(busy_ticks, 0.5), "tick"});
  rows.push_back({"drilling at 10 kHz beside a busy core, done after", knob, share, "of the deadlines missed",
                  quantile(late, 0.5), "tick"});
}

}  // namespace

std::vector<BenchRow> bench_contact(const BenchOptions& options) {
  std::vector<BenchRow> rows;
  slide_rows(options, rows);
  drilling_rows(options, rows);
  removal_rows(options, rows);
  free_air_row(options, rows);
  deadline_rows(options, false, rows);
  deadline_rows(options, true, rows);
  return rows;
}

}  // namespace typodont::haptics
