// Error and time of the calibration's solvers, with Eigen and OpenCV on the same seeded data.
#include <Eigen/Dense>
#include <ctime>
#include <memory>

#include "calibration/bench_simulator.h"
#include "calibration/camera_solver.h"
#include "calibration/joint_solver.h"
#include "calibration/statistics.h"
#include "engine/base/units.h"
#include "tests/bench/bench.h"
#ifdef TYPODONT_CAMERA
#include <opencv2/calib3d.hpp>
#endif

namespace typodont::bench {

namespace {

using namespace calibration;
constexpr double kSigma = 2e-4;  // m, standard deviation of the simulated noise
int trials() {
  return smoke() ? 8 : 200;
}

/// Processor time of all threads of this program, ns: the median of seven batches.
template <class F>
double cpu_ns(int repeats, F&& work) {
  std::vector<double> times;
  for (int batch = 0; batch < (smoke() ? 1 : 7); ++batch) {
    const std::clock_t start = std::clock();
    for (int i = 0; i < repeats; ++i) work();
    times.push_back(1e9 * static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC / repeats);
  }
  return quantile(times, 0.5);
}

struct Pairs {
  Pose X_DH;
  std::vector<dvec3> H, D;
  Pairs(Noise& random, int count, double outliers) {
    X_DH = {random.in_box(dvec3(-0.3), dvec3(0.3)), random.rotation()};
    for (int i = 0; i < count; ++i) {
      H.push_back(random.in_box(dvec3(-0.04), dvec3(0.04)));
      D.push_back(X_DH * H.back() + random.normal3(kSigma));
      if (i < outliers * count) D.back() += random.in_box(dvec3(-0.03), dvec3(0.03));
    }
  }
};

/// A motion that a solver found, as a function of a point.
using Found = std::function<dvec3(const dvec3&)>;
using Solver = std::function<Found(const Pairs&)>;

/// Returns the squared error (m²) at the corners of a cube of 80 mm.
double corner_error2(const Found& found, const Pose& truth) {
  double sum = 0;
  for (int c = 0; c < 8; ++c) {
    const dvec3 p = 0.04 * dvec3(c & 1 ? 1 : -1, c & 2 ? 1 : -1, c & 4 ? 1 : -1), e = found(p) - truth * p;
    sum += glm::dot(e, e) / 8;
  }
  return sum;
}

/// Time and error of a solver. The next solvers of the same task must not be faster or better.
struct Measured {
  double ns = 0, error = 0;
};

void solve(benchmark::State& state, const Solver& solver, int touches, double outliers, Measured& measured) {
  Noise random(static_cast<std::uint64_t>(touches));
  double sum = 0;
  for (int t = 0; t < trials(); ++t) {
    const Pairs pairs(random, touches, outliers);
    sum += corner_error2(solver(pairs), pairs.X_DH) / trials();
  }
  const Pairs pairs(random, touches, outliers);
  Found kept;
  measured = {
      cpu_ns(std::max(1, (outliers < 0 ? 20'000 : 400) / touches / (smoke() ? 20 : 1)), [&] { kept = solver(pairs); }),
      1e3 * std::sqrt(sum)};
  set_time(state, measured.ns);
  state.counters["error_mm"] = measured.error;
}

/// Adds the same task for several solvers, ours first. `outliers`: fraction of wrong touches; below 0: plain fit.
void add_task(const std::string& task, int touches, double outliers,
              const std::vector<std::pair<const char*, Solver>>& solvers) {
  const auto ours = std::make_shared<Measured>();
  for (const auto& [name, solver] : solvers) {
    add(fmt::format("{}/{}/{} touches", task, name, touches),
        [=, first = name == solvers.front().first, solver = solver](benchmark::State& state) {
          Measured measured;
          solve(state, solver, touches, outliers, measured);
          if (first) *ours = measured;
          const std::string claim = fmt::format(" than another solver: {}, {} touches", task, touches);
          require_time(ours->ns <= measured.ns, "ours is not slower" + claim);
          require(smoke() || ours->error <= measured.error * 1.001, "ours is not worse" + claim);
        });
  }
}

Found rigid(const Pose& X) {
  return [X](const dvec3& p) { return X * p; };
}

Found by_eigen(const Pairs& pairs) {
  using Points = Eigen::Map<const Eigen::Matrix<double, 3, Eigen::Dynamic>>;
  const auto n = static_cast<Eigen::Index>(pairs.H.size());
  const Eigen::Matrix4d X = Eigen::umeyama(Points(&pairs.H[0].x, 3, n), Points(&pairs.D[0].x, 3, n), false);
  return [X](const dvec3& p) {
    const Eigen::Vector4d q = X * Eigen::Vector4d(p.x, p.y, p.z, 1);
    return dvec3(q.x(), q.y(), q.z());
  };
}

#ifdef TYPODONT_CAMERA
cv::Mat points_of(const std::vector<dvec3>& points) {
  return cv::Mat(static_cast<int>(points.size()), 3, CV_64F, const_cast<dvec3*>(points.data()));
}
Found affine(const cv::Mat& m) {
  return [m](const dvec3& p) {
    dvec3 q;
    for (int i = 0; i < 3; ++i)
      q[i] = m.at<double>(i, 0) * p.x + m.at<double>(i, 1) * p.y + m.at<double>(i, 2) * p.z + m.at<double>(i, 3);
    return q;
  };
}
Found by_opencv(const Pairs& pairs) {
  double scale = 1;
  return affine(cv::estimateAffine3D(points_of(pairs.H), points_of(pairs.D), &scale, true));
}
/// An affine motion, because OpenCV has no robust fit of a rigid one.
Found by_ransac(const Pairs& pairs) {
  cv::Mat m, inliers;
  cv::estimateAffine3D(points_of(pairs.H), points_of(pairs.D), m, inliers, 5 * kSigma, 0.99);
  return affine(m);
}
#endif

void add_registration() {
  std::vector<std::pair<const char*, Solver>> plain{
      {"typodont", [](const Pairs& p) { return rigid(fit_rigid(p.H, p.D)); }}, {"Eigen", by_eigen}};
  // OpenCV needs the noise as its threshold, so ours gets it, too.
  RegistrationOptions known;
  known.known_sigma = kSigma;
  std::vector<std::pair<const char*, Solver>> robust{
      {"typodont", [known](const Pairs& p) { return rigid(register_points(p.H, p.D, known).X_DH); }}};
#ifdef TYPODONT_CAMERA
  plain.emplace_back("OpenCV", by_opencv);
  robust.emplace_back("OpenCV", by_ransac);
#endif
  for (const int touches : {4, 16, 64, 1000}) add_task("register", touches, -1, plain);
  for (const double outliers : {0.0, 0.3, 0.6})
    for (const int touches : {16, 64})
      add_task(fmt::format("register, {:g} % outliers", 100 * outliers), touches, outliers, robust);
}

void delay(benchmark::State& state, int samples) {
  const auto hand = [](double t) {
    return dvec3(0.03 * std::sin(1.9 * t) + 0.01 * std::sin(5.3 * t + 1), 0.02 * std::sin(2.7 * t + 2),
                 0.025 * std::cos(1.3 * t) + 0.006 * std::sin(9.7 * t));
  };
  Noise random(static_cast<std::uint64_t>(samples));
  Stream a, b;
  double squares = 0, information = 0;
  const int runs = smoke() ? 2 : 16;
  for (int t = 0; t < runs; ++t) {
    a = b = {};
    const double truth = random.uniform(-0.05, 0.05);
    for (int i = 0; i < samples; ++i) {
      a.t.push_back(0.01 * i), b.t.push_back(0.01 * i);
      a.p.push_back(hand(0.01 * i) + random.normal3(kSigma));
      b.p.push_back(hand(0.01 * i - truth) + random.normal3(kSigma));
    }
    squares += std::pow(estimate_delay(a, b, {0.3}).delay - truth, 2) / runs;
  }
  for (int i = 0; i < samples; ++i) {
    const dvec3 v = (hand(0.01 * i + 1e-5) - hand(0.01 * i - 1e-5)) / 2e-5;
    information += glm::dot(v, v);
  }
  set_time(state, cpu_ns(1, [&] { (void)estimate_delay(a, b, {0.3}); }));
  state.counters["error_ms"] = 1e3 * std::sqrt(squares);
  state.counters["cramer_rao_ms"] = 1e3 * std::sqrt(2 * kSigma * kSigma / information);
}

/// The whole routine on simulated benches. `touches`: number of touches relative to the usual one.
void routine(benchmark::State& state, double touches) {
  const int seeds = smoke() ? 1 : 4;
  double squares = 0, captures = 0;
  std::vector<double> joint;
  for (int seed = 1; seed <= seeds; ++seed) {
    SimulationOptions options;
    options.seed = static_cast<std::uint64_t>(seed), options.touches = touches;
    const SimulatedRoutine run = simulate_routine(options);
    squares += run.after.rms * run.after.rms / seeds;
    const Captures& c = run.captures;
    captures =
        static_cast<double>(c.arm.size() + c.marks.size() + c.mirror.size() + c.eyes.size() + c.registration.size());
    joint.push_back(1e9 * run.bench.joint->seconds);
  }
  set_time(state, quantile(joint, 0.5));
  state.counters["captures"] = captures;
  state.counters["error_mm"] = 1e3 * std::sqrt(squares);
}

#ifdef TYPODONT_CAMERA
/// Our solver for panel and camera, and OpenCV's for the camera alone, on the same pictures of the panel.
void camera(benchmark::State& state, int pictures) {
  const CameraIntrinsics truth{1450, 1440, 955, 545, {-0.12, 0.08, 0.0006, -0.0004, 0}};
  const RigGeometry rig = BenchSimulator({}).truth();
  const dvec3 middle = rig.panel.at(0.5, 0.5);
  const dvec3 right = rig.panel.lower_right - rig.panel.lower_left, up = rig.panel.upper_left - rig.panel.lower_left;
  const dvec3 front = glm::normalize(glm::cross(right, up));
  const int runs = smoke() ? 1 : 8;
  double ours = 0, theirs = 0;
  std::vector<double> our_time, their_time;
  for (int run = 0; run < runs; ++run) {
    Noise random(static_cast<std::uint64_t>(5 + run));
    std::vector<Sighting> sightings;
    std::vector<std::vector<cv::Point3f>> objects(static_cast<std::size_t>(pictures));
    std::vector<std::vector<cv::Point2f>> images(objects.size());
    for (int picture = 0; picture < pictures; ++picture) {
      const dvec3 from = middle + 0.5 * front + random.in_box(dvec3(-0.25), dvec3(0.25));
      const dvec3 z = glm::normalize(middle - from), x = glm::normalize(glm::cross(z, dvec3(0.2, 1, 0.1)));
      const Pose X_WK{from, glm::quat_cast(glm::dmat3(x, glm::cross(z, x), z))};
      const auto see = [&](Sighting s, const dvec3& p) {
        const Pixel pixel = project(truth, X_WK, p);
        s.picture = picture, s.px = pixel.x + random.normal(0.1), s.py = pixel.y + random.normal(0.1);
        sightings.push_back(s);
        if (s.on != SeenOn::kPanel) return;
        const auto k = static_cast<std::size_t>(picture);
        objects[k].emplace_back(s.corner.u * glm::length(right), s.corner.v * glm::length(up), 0);
        images[k].emplace_back(s.px, s.py);
      };
      for (int i = 0; i < 54; ++i) {
        const PanelPoint c{0.1 + 0.1 * (i % 9), 0.15 + 0.14 * (i / 9)};
        see({0, SeenOn::kPanel, c, {}, 0, 0}, rig.panel.at(c.u, c.v));
      }
      for (int i = 0; i < 12; ++i) {
        const dvec3 p = middle + dvec3(0.04 * (i % 4 - 1.5), -0.08, 0.04 * (i / 4 - 1));
        see({0, SeenOn::kTouchedPoint, {}, p, 0, 0}, p);
      }
    }
    CameraResult found;
    our_time.push_back(cpu_ns(1, [&] { found = solve_camera(sightings, 1920, 1080, rig.panel); }));
    ours += std::pow(found.camera.fx - truth.fx, 2) / runs;
    cv::Mat K, distortion;
    std::vector<cv::Mat> rotations, translations;
    their_time.push_back(cpu_ns(1, [&] {
      cv::calibrateCamera(objects, images, {1920, 1080}, K, distortion, rotations, translations);
    }));
    theirs += std::pow(K.at<double>(0, 0) - truth.fx, 2) / runs;
  }
  set_time(state, quantile(our_time, 0.5));
  state.counters["focal_error_pixels"] = std::sqrt(ours);
  state.counters["opencv_ns"] = quantile(their_time, 0.5);
  state.counters["opencv_focal_error_pixels"] = std::sqrt(theirs);
  require_time(quantile(our_time, 0.5) <= quantile(their_time, 0.5), "our camera solver is not slower than OpenCV's");
  require(ours <= theirs, "our camera solver is not worse than OpenCV's");
}
#endif

}  // namespace

void add_cases() {
  add_registration();
  for (const int samples : {200, 1000})
    add(fmt::format("delay/{} samples", samples), [=](benchmark::State& state) { delay(state, samples); });
  for (const double touches : smoke() ? std::vector{0.25} : std::vector{0.25, 0.5, 1.0, 2.0})
    add(fmt::format("whole routine/{:g} of the usual touches", touches),
        [=](benchmark::State& state) { routine(state, touches); });
#ifdef TYPODONT_CAMERA
  for (const int pictures : {6, 12})
    add(fmt::format("camera/{} pictures", pictures), [=](benchmark::State& state) { camera(state, pictures); });
#endif
}

}  // namespace typodont::bench
