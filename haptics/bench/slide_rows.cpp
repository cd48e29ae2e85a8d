#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/dispatch.h"
#include "haptics/bench/offset_mesh.h"
#include "haptics/bench/rows.h"
#include "haptics/bench/timing.h"
#include "haptics/contact_method.h"
#include "haptics/lanes.h"
#include "haptics/volume/penalty_baseline.h"

namespace typodont::haptics::bench {

namespace {

/// Returns the position of a hand that slides on a ball: 0.4 mm deep, on an oblique great circle, at 20 mm/s.
dvec3 sliding(int tick, double radius) {
  const double angle = 0.02 * 1e-3 * tick / radius + 0.3;
  const dvec3 u = glm::normalize(dvec3(1, 0.3, 0.2)), v = glm::normalize(glm::cross(u, dvec3(0.2, -0.1, 1)));
  return (radius - 4e-4) * (std::cos(angle) * u + std::sin(angle) * v);
}

constexpr int kApproach = 50;  // number of ticks after which the force has risen completely
// Number of successive ticks whose time is measured together. The time to read the clock is as long as a tick.
constexpr int kBatch = 20;

/// Measures a slide on one ball with one voxel size.
struct Slide {
  const BenchOptions& options;
  std::vector<BenchRow>& rows;
  DenseTissue dense;
  std::string knob;
  ServoSettings settings;
  double radius;  // m, radius of the circular path of the head's centre
  dvec3 outside;

  Slide(const BenchOptions& o, double voxel_mm, std::vector<BenchRow>& r)
      : options(o), rows(r), dense(tissue(kBall, voxel_mm)), knob(fmt::format("voxel {:g} mm", voxel_mm)) {
    settings.tool = head(HeadShape::kSphere, 1.2e-3, 1.2e-3);
    // friction is off, because it would change the direction of the force, which is measured
    settings.friction = false;
    settings.damping = 0;
    settings.cutting = false;
    radius = kBallRadius + settings.tool.radius();
    outside = 1.1 * sliding(0, radius);
  }

  void add(const char* name, double error, double ns, const char* work, const char* baseline = "", double of_it = 0) {
    rows.push_back(
        {name, knob, error, "degree, greatest", ns, work, baseline, of_it > 0 ? ns / of_it : BenchRow::kNone});
  }

  /// Moves a hand along the path in batches of successive ticks. Returns the mean time of a tick for each batch in ns.
  /// Sets `error` to the error of the force's direction. `start()` begins a slide and returns two functions:
  /// `prepare(p)` prepares a batch that begins at the hand's position p, and is not measured; `direction(p)` computes
  /// one tick, and returns a vector in the direction of the force.
  template <class Start>
  std::vector<double> slide_in_batches(double& error, Start start) {
    return least_of(
        [&] {
          auto [prepare, direction] = start();
          std::vector<double> run;
          error = 0;
          for (int first = 0; first + kBatch <= options.ticks; first += kBatch) {
            dvec3 p[kBatch], f[kBatch];
            for (int k = 0; k < kBatch; ++k) p[k] = sliding(first + k, radius);
            prepare(p[0]);
            const Nanos before = thread_cpu_time();
            for (int k = 0; k < kBatch; ++k) f[k] = direction(p[k]);
            run.push_back(static_cast<double>(thread_cpu_time() - before) / kBatch);
            for (int k = 0; k < kBatch; ++k)
              if (first + k > kApproach) error = std::max(error, degrees_between(f[k], p[k]));
          }
          return run;
        },
        kBatch);
  }

  /// Slides with the method in `settings`. Returns the median time of a tick in ns. Sets `error` to the error of the
  /// force's direction.
  double slide(double& error) {
    const std::vector<double> times = slide_in_batches(error, [&] {
      auto scene = std::make_shared<Scene>(dense, settings);
      scene->tick({outside}, 0);
      const auto prepare = [scene](const dvec3& p) {
        scene->last.X_WT.p = p;
        scene->renew_patch({p});
      };
      const auto direction = [&s = *scene](const dvec3& p) {
        s.servo.tick({s.t, {p}, 0}, s.last, s.cut);
        s.t += from_seconds(s.settings.tick);
        return s.last.f_T_W;
      };
      return std::pair(prepare, direction);
    });
    return quantile(times, 0.5);
  }

  /// Slides with the method in `settings` and measures each tick alone. Returns a quantile of the times in ns.
  double slow_tick(double share) {
    const std::vector<double> times = least_of([&] {
      Scene scene(dense, settings);
      std::vector<double> run;
      scene.tick({outside}, 0);
      for (int i = 0; i < options.ticks; ++i) run.push_back(scene.tick({sliding(i, radius)}, 0));
      return run;
    });
    return quantile(times, share);
  }

  /// Measures a penalty method with springs between head samples and voxels, as in CHAI3D and AMBF. Returns the median
  /// time of a tick in ns.
  double by_voxel_penalty() {
    settings.method = contact_method("voxel_penalty", "bench");
    double error = 0;
    const double ns = slide(error);
    settings.method = options.method;
    add("slide on a sphere, voxel penalty", error, ns, "tick");
    return ns;
  }

  /// Measures a proxy on the offset surface, which makes eight field queries per tick. `sample` is the function that
  /// interpolates the field; the rows compare trilinear and cubic interpolation.
  template <class Sample>
  void by_looks(Sample sample, const char* name, double penalty_ns) {
    double error = 0;
    const std::vector<double> ticks = slide_in_batches(error, [&] {
      struct State {
        Scene still;
        SurfacePatch patch;
        dvec3 c;
        explicit State(const Slide& s)
            : still(s.dense, s.settings),
              patch(empty_patch_for(tool_set(s.settings), s.dense.frame.voxel)),
              c(s.dense.frame.to_voxels(s.outside)) {}
      };
      auto state = std::make_shared<State>(*this);
      const auto prepare = [this, state](const dvec3& p) {
        ServoTick& last = state->still.last;
        Carver& carver = state->still.carver;
        last.X_WT.p = p, last.X_WG.p = dense.frame.to_world(state->c);
        if (carver.snapshot_due(last)) carver.take_snapshot(carver.snapshot_center(last), state->patch);
      };
      const auto direction = [this, sample, &patch = state->patch, &c = state->c](const dvec3& p) {
        const dvec3 goal = dense.frame.to_voxels(p);
        for (int look = 0; look < 8; ++look) {
          const FieldSample at = sample(patch, c);
          const dvec3 n = glm::normalize(at.gradient);
          c = goal + n * (settings.tool.radius() / dense.frame.voxel - at.value + glm::dot(n, c - goal));
        }
        return c - goal;
      };
      return std::pair(prepare, direction);
    });
    add(name, error, quantile(ticks, 0.5), "tick", "voxel penalty", penalty_ns);
  }

  /// Measures methods that other programs use. They are implemented here, and slide on the same path as the servo.
  /// `directions()` returns a function that computes the force's direction from the hand's position.
  template <class Directions>
  void by_yardstick(const char* name, const std::string& of, double servo_ns, Directions directions) {
    double error = 0;
    const std::vector<double> ticks =
        slide_in_batches(error, [&] { return std::pair([](const dvec3&) {}, directions()); });
    const double ns = quantile(ticks, 0.5);
    rows.push_back({name, of, error, "degree, greatest", ns, "tick", "the servo's slide", ns / servo_ns});
  }

  void yardsticks(double servo_ns) {
    by_yardstick("slide on a sphere, penalty by OpenVDB's field alone", knob, servo_ns, [&] {
      return [penalty = std::make_shared<PenaltyBaseline>(dense), r = settings.tool.radius()](const dvec3& p) {
        return penalty->push(p, r) - p;
      };
    });
    for (const int subdivisions : {5, 6}) {
      const auto mesh = std::make_shared<OffsetMesh>(radius, subdivisions);
      by_yardstick("slide on a sphere, point proxy on the offset mesh, shaded",
                   fmt::format("{}, {} triangles", knob, mesh->triangles()), servo_ns, [&] {
                     mesh->place(outside);
                     return [mesh](const dvec3& p) { return mesh->follow(p); };
                   });
    }
  }

  /// Measures the servo. Returns the median time of a tick in ns.
  double by_servo(double penalty_ns) {
    double error = 0;
    const double median = slide(error);
    add("slide on a sphere, median", error, median, "tick", "voxel penalty", penalty_ns);
    add("slide on a sphere, 99.9 %", error, slow_tick(0.999), "tick");
    return median;
  }

  /// Measures the time of a single query of the field near the head's centre, as the mean over a batch of queries. Also
  /// measures the time in which the processor only reads the same samples, which is a lower bound of a query's time.
  void queries() {
    Scene scene(dense, settings);
    scene.tick({sliding(0, radius)}, 0);
    const SurfacePatch& patch = scene.patch();
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
      add(name, worst, ns, "query", linear_ns > 0 ? "trilinear" : "", linear_ns);
      return ns;
    };
    const double linear_ns = query(sample_linear_gradient, "direction, trilinear", 0);
    const double cubic_ns = query(sample_cubic, "direction, cubic", linear_ns);
    query_floor(patch, points, cubic_ns);
  }

  /// Measures a lower bound for the time of a query: the time to read and add the 6 × 6 rows of samples that a query
  /// needs. The points are computed before the measurement.
  void query_floor(const SurfacePatch& patch, const std::vector<dvec3>& points, double cubic_ns);
};

/// Sums up 6 × 6 rows of eight samples. Uses six independent sums, so that an addition need not wait for the previous
/// one.
TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
void scan_rows(const float* corner, std::size_t edge, float* sum) {
  F8 sums[6] = {};
  for (std::size_t i = 0; i < 6; ++i) {
    for (std::size_t j = 0; j < 6; ++j) sums[j] += *reinterpret_cast<const F8*>(corner + (i * edge + j) * edge);
  }
  *sum += sum_of(((sums[0] + sums[1]) + (sums[2] + sums[3])) + (sums[4] + sums[5]));
}

void Slide::query_floor(const SurfacePatch& patch, const std::vector<dvec3>& points, double cubic_ns) {
  std::vector<const float*> corners;
  for (const dvec3& p : points) {
    const glm::ivec3 corner = glm::ivec3(p) - patch.lo - glm::ivec3(2, 2, 4);
    corners.push_back(patch.distance.data() + patch.at(corner.x, corner.y, corner.z));
  }
  float read = 0;
  const std::size_t edge = static_cast<std::size_t>(patch.n);
  const double scan_ns =
      batch_ns(51, 256, [&](int k) { scan_rows(corners[static_cast<std::size_t>(k)], edge, &read); });
  rows.push_back({"floor: scan of the samples a cubic query reads", knob, BenchRow::kNone, "", scan_ns, "query", "",
                  BenchRow::kNone, std::isfinite(read) ? 288.0 : 0.0, "samples"});
  rows.push_back({"direction, cubic, against the floor", knob, BenchRow::kNone, "", cubic_ns, "query", "the scan",
                  cubic_ns / scan_ns});
}

}  // namespace

void slide_rows(const BenchOptions& options, std::vector<BenchRow>& rows) {
  for (const double voxel_mm : options.voxels_mm) {
    Slide slide(options, voxel_mm, rows);
    const double penalty_ns = slide.by_voxel_penalty();
    if (by_default(options)) {
      slide.by_looks(sample_linear_gradient, "slide on a sphere, eight trilinear queries", penalty_ns);
      slide.by_looks(sample_cubic, "slide on a sphere, eight cubic queries", penalty_ns);
    }
    const double servo_ns = slide.by_servo(penalty_ns);
    if (!by_default(options)) continue;
    slide.yardsticks(servo_ns);
    slide.queries();
  }
}

}  // namespace typodont::haptics::bench
