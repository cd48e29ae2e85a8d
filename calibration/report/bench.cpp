#include "calibration/bench.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <ctime>
#include <functional>

#include "calibration/bench_simulator.h"
#include "calibration/camera_solver.h"
#include "calibration/joint_solver.h"
#include "calibration/statistics.h"
#include "engine/base/units.h"
#ifdef TYPODONT_CAMERA
#include "calibration/capture/opencv_solvers.h"
#endif

namespace typodont::calibration {

namespace {

constexpr double kSigma = 2e-4;  // m, standard deviation of the simulated noise
constexpr double kNone = BenchRow::kNone;

/// `touches`: pairs, samples, captures or corners; `time_us`: one solution.
BenchRow row(const std::string& task, const std::string& method, int touches, double error, const char* unit,
             double time_us) {
  return {.name = task + ", " + method,
          .knob = std::to_string(touches) + " touches",
          .error = error,
          .error_unit = unit,
          .time_ns = time_us * 1e3,
          .per = "solution",
          .size = static_cast<double>(touches),
          .size_unit = "touches"};
}

/// Time ratios of rows from `first` to the last one, their baseline (`method`).
void beside(std::vector<BenchRow>& rows, const char* method, std::size_t first) {
  const BenchRow& other = rows.back();
  for (std::size_t i = first; i + 1 < rows.size(); ++i) {
    rows[i].baseline = method, rows[i].ratio = rows[i].time_ns / other.time_ns;
  }
}

double microseconds(const std::function<void()>& work, int repeats) {
  std::vector<double> times;
  for (int batch = 0; batch < 7; ++batch) {
    // CPU time of all threads.
    const std::clock_t start = std::clock();
    for (int i = 0; i < repeats; ++i) work();
    times.push_back(1e6 * static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC / repeats);
  }
  std::nth_element(times.begin(), times.begin() + 3, times.end());
  return times[3];
}

Pose eigen_umeyama(std::span<const dvec3> h, std::span<const dvec3> d) {
  using Points = Eigen::Map<const Eigen::Matrix<double, 3, Eigen::Dynamic>>;
  const auto n = static_cast<Eigen::Index>(h.size());
  const Eigen::Matrix4d X = Eigen::umeyama(Points(&h[0].x, 3, n), Points(&d[0].x, 3, n), false);
  const Eigen::Quaterniond q(Eigen::Matrix3d(X.topLeftCorner<3, 3>()));
  return {dvec3(X(0, 3), X(1, 3), X(2, 3)), dquat(q.w(), q.x(), q.y(), q.z())};
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

// Mean squared error (m²) at the corners of an 80 mm cube.
double corner_error2(const std::function<dvec3(const dvec3&)>& found, const Pose& truth) {
  double sum = 0;
  for (int c = 0; c < 8; ++c) {
    const dvec3 p = 0.04 * dvec3(c & 1 ? 1 : -1, c & 2 ? 1 : -1, c & 4 ? 1 : -1);
    const dvec3 e = found(p) - truth * p;
    sum += glm::dot(e, e) / 8;
  }
  return sum;
}

void register_rows(std::vector<BenchRow>& rows, int trials) {
  using Solver = std::function<Pose(std::span<const dvec3>, std::span<const dvec3>)>;
  std::vector<std::pair<const char*, Solver>> solvers{{"typodont", fit_rigid}, {"Eigen umeyama", eigen_umeyama}};
#ifdef TYPODONT_CAMERA
  solvers.emplace_back("OpenCV estimateAffine3D", opencv_rigid);
#endif
  for (const int count : {4, 8, 16, 32, 64, 256, 1000}) {
    for (const auto& [method, solve] : solvers) {
      Noise random(static_cast<std::uint64_t>(count));
      double sum = 0;
      for (int t = 0; t < trials; ++t) {
        const Pairs pairs(random, count, 0);
        const Pose X = solve(pairs.H, pairs.D);
        sum += corner_error2([&](const dvec3& p) { return X * p; }, pairs.X_DH) / trials;
      }
      const Pairs pairs(random, count, 0);
      Pose kept;
      const double time = microseconds([&, &solver = solve] { kept = solver(pairs.H, pairs.D); },
                                       std::max(1, 20'000 / count / (trials < 50 ? 10 : 1)));
      rows.push_back(row("register", method, count, std::sqrt(sum) * 1e3, "mm at the corners", time));
    }
    beside(rows, solvers.back().first, rows.size() - solvers.size());
  }
  for (const double outliers : {0.0, 0.3, 0.6}) {
    const std::string task = "register, " + std::to_string(static_cast<int>(100 * outliers)) + " % outliers";
    for (const int count : {16, 64, 256}) {
      const int runs = std::max(4, trials / 10);
      Noise random(static_cast<std::uint64_t>(count));
      RegistrationOptions known;
      // OpenCV gets it as its threshold, too
      known.known_sigma = kSigma;
      double blind = 0, ours = 0, theirs = 0;
      for (int t = 0; t < runs; ++t) {
        const Pairs pairs(random, count, outliers);
        const auto error2 = [&](const Pose& X) {
          return corner_error2([&](const dvec3& p) { return X * p; }, pairs.X_DH) / runs;
        };
        ours += error2(register_points(pairs.H, pairs.D, known).X_DH);
        blind += error2(register_points(pairs.H, pairs.D).X_DH);
#ifdef TYPODONT_CAMERA
        theirs +=
            corner_error2([&](const dvec3& p) { return opencv_robust(pairs.H, pairs.D, 5 * kSigma, p); }, pairs.X_DH) /
            runs;
#endif
      }
      const Pairs pairs(random, count, outliers);
      rows.push_back(row(task, "typodont", count, std::sqrt(ours) * 1e3, "mm at the corners",
                         microseconds([&] { (void)register_points(pairs.H, pairs.D, known); }, 20)));
      rows.push_back(row(task, "typodont, noise estimated", count, std::sqrt(blind) * 1e3, "mm at the corners",
                         microseconds([&] { (void)register_points(pairs.H, pairs.D); }, 1)));
#ifdef TYPODONT_CAMERA
      rows.push_back(row(task, "OpenCV estimateAffine3D RANSAC", count, std::sqrt(theirs) * 1e3, "mm at the corners",
                         microseconds([&] { (void)opencv_robust(pairs.H, pairs.D, 5 * kSigma, dvec3(0)); }, 20)));
      beside(rows, "OpenCV estimateAffine3D RANSAC", rows.size() - 3);
#else
      (void)theirs;
#endif
    }
  }
}

// Standard method: cross-correlation along the main axis, parabola through the peak.
double correlation_delay(const Stream& a, const Stream& b, double step) {
  const auto n = static_cast<int>(std::min(a.t.size(), b.t.size()));
  const auto at = [](const Stream& s, int i) { return s.p[static_cast<std::size_t>(i)]; };
  dvec3 mean_a(0), mean_b(0);
  for (int i = 0; i < n; ++i) mean_a += at(a, i) / static_cast<double>(n), mean_b += at(b, i) / static_cast<double>(n);
  const auto correlation = [&](int lag) {
    double sum = 0;
    for (int i = std::max(0, -lag); i < std::min(n, n - lag); ++i)
      sum += glm::dot(at(a, i) - mean_a, at(b, i + lag) - mean_b);
    return sum / (n - std::abs(lag));
  };
  int best = 0;
  for (int lag = -n / 4; lag <= n / 4; ++lag) best = correlation(lag) > correlation(best) ? lag : best;
  const double l = correlation(best - 1), m = correlation(best), r = correlation(best + 1);
  return (best + 0.5 * (l - r) / (l - 2 * m + r)) * step;
}

void delay_rows(std::vector<BenchRow>& rows, int trials) {
  const auto hand = [](double t) {
    return dvec3(0.03 * std::sin(1.9 * t) + 0.01 * std::sin(5.3 * t + 1), 0.02 * std::sin(2.7 * t + 2),
                 0.025 * std::cos(1.3 * t) + 0.006 * std::sin(9.7 * t));
  };
  for (const int samples : {200, 500, 1000, 2000}) {
    Noise random(static_cast<std::uint64_t>(samples));
    double ours = 0, plain = 0, information = 0;
    const int runs = std::max(3, trials / 12);
    Stream a, b;
    volatile double kept = 0;  // keeps the compiler from removing the measured work
    for (int t = 0; t < runs; ++t) {
      a = b = {};
      const double delay = random.uniform(-0.05, 0.05);
      for (int i = 0; i < samples; ++i) {
        a.t.push_back(0.01 * i), b.t.push_back(0.01 * i);
        a.p.push_back(hand(0.01 * i) + random.normal3(kSigma)),
            b.p.push_back(hand(0.01 * i - delay) + random.normal3(kSigma));
      }
      ours += std::pow(estimate_delay(a, b, {0.3}).delay - delay, 2) / runs;
      plain += std::pow(correlation_delay(a, b, 0.01) - delay, 2) / runs;
    }
    for (int i = 0; i < samples; ++i) {
      const dvec3 v = (hand(0.01 * i + 1e-5) - hand(0.01 * i - 1e-5)) / 2e-5;
      information += glm::dot(v, v);
    }
    rows.push_back(row("delay", "typodont", samples, std::sqrt(ours) * 1e3, "ms",
                       microseconds([&] { (void)estimate_delay(a, b, {0.3}); }, 1)));
    rows.push_back(row("delay", "cross-correlation", samples, std::sqrt(plain) * 1e3, "ms",
                       microseconds([&] { kept = correlation_delay(a, b, 0.01); }, 1)));
    beside(rows, "cross-correlation", rows.size() - 2);
    rows.push_back(row("delay", "bound", samples, std::sqrt(2 * kSigma * kSigma / information) * 1e3, "ms", kNone));
  }
}

void routine_rows(std::vector<BenchRow>& rows, bool quick) {
  for (const double touches : {0.25, 0.5, 1.0, 2.0}) {
    if (quick && touches > 0.5) break;
    double error = 0;
    std::vector<double> arm, joint;
    int captures = 0;
    const int runs = quick ? 1 : 4;
    for (int seed = 1; seed <= runs; ++seed) {
      SimulationOptions options;
      options.seed = static_cast<std::uint64_t>(seed), options.touches = touches;
      const SimulatedRoutine run = simulate_routine(options);
      error += run.after.rms * run.after.rms / runs;
      const Captures& c = run.captures;
      captures =
          static_cast<int>(c.arm.size() + c.marks.size() + c.mirror.size() + c.eyes.size() + c.registration.size());
      BenchState state = BenchSimulator(options).drawings();
      arm.push_back(microseconds([&] { (void)solve_arm(c.arm, state.arm); }, 1));
      joint.push_back(run.bench.joint->seconds * 1e6);
    }
    std::sort(arm.begin(), arm.end()), std::sort(joint.begin(), joint.end());
    rows.push_back(row("whole routine", "typodont, all together", captures, std::sqrt(error) * 1e3, "mm over the cube",
                       joint[joint.size() / 2]));
    rows.push_back(row("arm alone", "typodont", static_cast<int>(310 * touches), kNone, "", arm[arm.size() / 2]));
  }
}

void camera_rows(std::vector<BenchRow>& rows, bool quick) {
  const CameraIntrinsics truth{1450, 1440, 955, 545, {-0.12, 0.08, 0.0006, -0.0004, 0}};
  const RigGeometry rig = BenchSimulator({}).truth();
  const dvec3 middle = rig.panel.at(0.5, 0.5);
  const dvec3 right = rig.panel.lower_right - rig.panel.lower_left, up = rig.panel.upper_left - rig.panel.lower_left;
  const dvec3 front = glm::normalize(glm::cross(right, up));
  for (const int pictures : {6, 12}) {
    if (quick && pictures > 6) break;
    const int runs = quick ? 2 : 8;
    double ours = 0, theirs = 0;  // sums of squared errors
    std::vector<double> our_time, their_time;
    int corners = 0;
    for (int run = 0; run < runs; ++run) {
      Noise random(static_cast<std::uint64_t>(5 + run));
      std::vector<Sighting> sightings;
      for (int picture = 0; picture < pictures; ++picture) {
        const dvec3 from = middle + 0.5 * front + random.in_box(dvec3(-0.25), dvec3(0.25));
        const dvec3 z = glm::normalize(middle - from), x = glm::normalize(glm::cross(z, dvec3(0.2, 1, 0.1)));
        const Pose X_WK{from, glm::quat_cast(glm::dmat3(x, glm::cross(z, x), z))};
        const auto see = [&](Sighting s, const dvec3& p) {
          const Pixel pixel = project(truth, X_WK, p);
          s.picture = picture, s.px = pixel.x + random.normal(0.1), s.py = pixel.y + random.normal(0.1);
          sightings.push_back(s);
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
      corners = static_cast<int>(sightings.size());
      CameraResult found;
      our_time.push_back(microseconds([&] { found = solve_camera(sightings, 1920, 1080, rig.panel); }, 1));
      ours += std::pow(found.camera.fx - truth.fx, 2) / runs;
#ifdef TYPODONT_CAMERA
      CameraIntrinsics other;
      their_time.push_back(microseconds(
          [&] { (void)opencv_calibration(sightings, 1920, 1080, glm::length(right), glm::length(up), other); }, 1));
      theirs += std::pow(other.fx - truth.fx, 2) / runs;
#endif
    }
    const auto median = [](std::vector<double> list) {
      std::sort(list.begin(), list.end());
      return list.empty() ? kNone : list[list.size() / 2];
    };
    rows.push_back(row("camera", "typodont, panel and camera", corners, std::sqrt(ours), "pixels of focal length",
                       median(our_time)));
#ifdef TYPODONT_CAMERA
    rows.push_back(row("camera", "OpenCV calibrateCamera, camera alone", corners, std::sqrt(theirs),
                       "pixels of focal length", median(their_time)));
    beside(rows, "OpenCV calibrateCamera", rows.size() - 2);
#endif
  }
}

}  // namespace

std::vector<BenchRow> bench_rows(bool quick) {
  std::vector<BenchRow> rows;
  const int trials = quick ? 20 : 200;
  register_rows(rows, trials);
  delay_rows(rows, trials);
  routine_rows(rows, quick);
  camera_rows(rows, quick);
  return rows;
}

}  // namespace typodont::calibration
