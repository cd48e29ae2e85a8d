#include "calibration/hand_eye_solver.h"

#include <ceres/ceres.h>
#include <ceres/jet.h>
#include <ceres/rotation.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>
#include <optional>

#include "calibration/solver/eigen_math.h"
#include "calibration/statistics.h"
#include "engine/base/error.h"
#include "engine/base/quantile.h"
#include "engine/base/units.h"

namespace typodont::calibration {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Matrix6 = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;
using Matrix9 = Eigen::Matrix<double, 9, 9>;
using Vector6 = Eigen::Matrix<double, 6, 1>;
using Indices = std::vector<std::size_t>;

// Lever arm that converts a rotation error to a displacement, as at a stylus, m.
constexpr double kLever = 0.1;
constexpr double kFloor = 1e-13;  // rad and m, smallest noise that is assumed, because of rounding errors
// Number of random triples of pairs. If half of the pairs are good, the probability that no triple is good is 1e-23.
constexpr std::size_t kTriples = 400;
constexpr std::size_t kRefined = 10;     // number of best random samples that concentrate() improves
constexpr std::size_t kMinToReject = 8;  // number of pairs below which none is rejected
// From this number of pairs on, noise is a full 6×6 matrix.
constexpr std::size_t kMinForFullNoise = 20;
// Smallest rms rotations of the arm from which a result is computed, rad: about the main axis; about the second.
constexpr double kMinMainTurn = 2 * kDegree, kMinSecondTurn = 1 * kDegree;
// If the arm's rms rotation divided by the rotation noise is smaller than this, there is no result.
constexpr double kTurnOverNoise = 4;

Pose pose_of(const Matrix3d& R, const Vector3d& p) {
  const Eigen::Quaterniond q(R);
  return {vec(p), glm::normalize(dquat(q.w(), q.x(), q.y(), q.z()))};
}
dvec3 rotation_vector(dquat q) {
  if (q.w < 0) q = -q;
  const dvec3 v(q.x, q.y, q.z);
  const double sine = glm::length(v);
  return sine < 1e-12 ? 2.0 * v : (2 * std::atan2(sine, q.w) / sine) * v;
}
dquat turned_by(const Vector3d& v) {
  const double angle = v.norm();
  const double k = angle < 1e-9 ? 0.5 : std::sin(0.5 * angle) / angle;
  return {std::cos(0.5 * angle), k * v.x(), k * v.y(), k * v.z()};
}

/// The unknown poses in A X = Z B: X of the sensor on the arm, Z of its fixed counterpart.
struct Unknowns {
  Pose X, Z;
};

/// Residual of a pair (A, B): the pose Z B relative to the pose A X, as a rotation vector and a
/// translation. Multiplied by the matrix `whitening`, so that all six numbers have equal noise.
struct Row {
  Pose A, B;
  Unknowns at;  // linearisation point
  Matrix6 whitening;

  template <class T>
  static void step(const Pose& from, const T* by, T* q, T* p) {
    T turn[4];
    ceres::AngleAxisToQuaternion(by, turn);
    const T R[4] = {T(from.R.w), T(from.R.x), T(from.R.y), T(from.R.z)};
    ceres::QuaternionProduct(turn, R, q);
    for (int i = 0; i < 3; ++i) p[i] = from.p[i] + by[3 + i];
  }

  template <class T>
  bool operator()(const T* x, const T* z, T* residual) const {
    T qX[4], pX[3], qZ[4], pZ[3];
    step(at.X, x, qX, pX);
    step(at.Z, z, qZ, pZ);
    const T qA[4] = {T(A.R.w), T(A.R.x), T(A.R.y), T(A.R.z)}, qB[4] = {T(B.R.w), T(B.R.x), T(B.R.y), T(B.R.z)};
    const T pB[3] = {T(B.p.x), T(B.p.y), T(B.p.z)};
    T predicted[4], inverse[4], measured[4], difference[4], by_arm[3], by_tracker[3], apart[3], r[6];
    ceres::QuaternionProduct(qA, qX, predicted);
    ceres::QuaternionProduct(qZ, qB, measured);
    inverse[0] = predicted[0];
    for (int i = 1; i < 4; ++i) inverse[i] = -predicted[i];
    ceres::QuaternionProduct(inverse, measured, difference);
    if (difference[0] < T(0)) {
      for (T& d : difference) d = -d;
    }
    ceres::QuaternionToAngleAxis(difference, r);
    ceres::UnitQuaternionRotatePoint(qA, pX, by_arm);
    ceres::UnitQuaternionRotatePoint(qZ, pB, by_tracker);
    for (int i = 0; i < 3; ++i) apart[i] = pZ[i] + by_tracker[i] - A.p[i] - by_arm[i];
    ceres::UnitQuaternionRotatePoint(inverse, apart, r + 3);
    for (int i = 0; i < 6; ++i) {
      residual[i] = T(0);
      for (int k = 0; k <= i; ++k) residual[i] += whitening(i, k) * r[k];
    }
    return true;
  }
  template <class T>
  bool operator()(const T* x, T* residual) const {
    return (*this)(x, x, residual);
  }
};

class Solver {
 public:
  Solver(std::span<const Pose> A, std::span<const Pose> B, const HandEyeOptions& options)
      : A_(A), B_(B), options_(options), n_(A.size()), parameters_(options.motions ? 6 : 12) {}

  HandEyeResult solve() {
    Indices rows(n_);
    std::iota(rows.begin(), rows.end(), 0u);
    find_turns(rows);
    if (result_.second_turn < kMinSecondTurn || result_.main_turn < kMinMainTurn) {
      refuse_turns(0);
      keep(closed_form(rows), rows);
      return std::move(result_);
    }
    if (options_.reject_outliers && n_ >= kMinToReject) rows = trimmed_rows();
    Unknowns at = closed_form(rows);
    for (int round = 0; round < 30; ++round) {
      refine(at, rows);
      if (!options_.reject_outliers || n_ < kMinToReject) break;
      Indices next = rows_within(at, rotation_sigma_, translation_sigma_, rows.size());
      if (next == rows || next.size() < 4) break;
      rows = std::move(next);
    }
    find_turns(rows);
    keep(at, rows);
    judge();
    return std::move(result_);
  }

 private:
  Vector6 residual(const Unknowns& at, std::size_t i) const {
    const Pose predicted = A_[i] * at.X, measured = at.Z * B_[i];
    const dvec3 turn = rotation_vector(glm::conjugate(predicted.R) * measured.R);
    const dvec3 shift = glm::conjugate(predicted.R) * (measured.p - predicted.p);
    Vector6 r;
    r << eigen(turn), eigen(shift);
    return r;
  }

  // R_X and R_Z maximise Σ tr(R_Zᵀ R_A R_X R_Bᵀ) (Shah 2013): singular vectors of Σ R_B ⊗ R_A (for motions an
  // eigenvector), then the nearest rotations.
  Unknowns closed_form(const Indices& rows) const {
    Matrix9 T = Matrix9::Zero();
    for (const std::size_t i : rows) {
      const Matrix3d a = eigen(A_[i].R), b = eigen(B_[i].R);
      for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c) T.block<3, 3>(3 * r, 3 * c) += b(r, c) * a;
      }
    }
    Matrix3d R_X, R_Z;
    if (options_.motions) {
      const Eigen::SelfAdjointEigenSolver<Matrix9> solver(0.5 * (T + T.transpose()));
      const Eigen::Matrix<double, 9, 1> v = solver.eigenvectors().col(8);
      R_X = Eigen::Map<const Matrix3d>(v.data());
      if (R_X.determinant() < 0) R_X = -R_X;
      R_X = nearest_rotation(R_X);
      R_Z = R_X;
    } else {
      const Eigen::JacobiSVD<Matrix9> svd(T, Eigen::ComputeFullU | Eigen::ComputeFullV);
      const Eigen::Matrix<double, 9, 1> u = svd.matrixU().col(0), v = svd.matrixV().col(0);
      R_Z = Eigen::Map<const Matrix3d>(u.data()), R_X = Eigen::Map<const Matrix3d>(v.data());
      if (R_X.determinant() < 0) R_X = -R_X, R_Z = -R_Z;
      R_X = nearest_rotation(R_X), R_Z = nearest_rotation(R_Z);
    }
    // Translations by least squares: R_A t_X - t_Z = R_Z t_B - t_A.
    const Eigen::Index unknowns = options_.motions ? 3 : 6;
    Eigen::MatrixXd J(3 * static_cast<Eigen::Index>(rows.size()), unknowns);
    Eigen::VectorXd d(J.rows());
    for (std::size_t k = 0; k < rows.size(); ++k) {
      const std::size_t i = rows[k];
      const auto row = 3 * static_cast<Eigen::Index>(k);
      if (options_.motions) {
        J.block<3, 3>(row, 0) = eigen(A_[i].R) - Matrix3d::Identity();
      } else {
        J.block<3, 3>(row, 0) = eigen(A_[i].R), J.block<3, 3>(row, 3) = -Matrix3d::Identity();
      }
      d.segment<3>(row) = R_Z * eigen(B_[i].p) - eigen(A_[i].p);
    }
    const Eigen::VectorXd t = J.completeOrthogonalDecomposition().solve(d);
    const Pose X = pose_of(R_X, t.head<3>());
    return {X, options_.motions ? X : pose_of(R_Z, t.tail<3>())};
  }

  /// Squared residual of a pair, m²; rotations × kLever.
  double distance2(const Unknowns& at, std::size_t i) const {
    const Vector6 r = residual(at, i);
    return kLever * kLever * r.head<3>().squaredNorm() + r.tail<3>().squaredNorm();
  }

  struct Sample {
    double score = std::numeric_limits<double>::infinity();  // m², sum of squared residuals over `rows`
    // Pairs with the smallest residuals: half of all, plus two.
    Indices rows;
  };
  Sample concentrate(const Indices& rows) const {
    const Unknowns at = closed_form(rows);
    std::vector<std::pair<double, std::size_t>> order(n_);
    for (std::size_t i = 0; i < n_; ++i) order[i] = {distance2(at, i), i};
    const std::size_t half = kept_half();
    std::nth_element(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(half - 1), order.end());
    Sample sample{0, {}};
    for (std::size_t k = 0; k < half; ++k) sample.score += order[k].first, sample.rows.push_back(order[k].second);
    std::sort(sample.rows.begin(), sample.rows.end());
    return sample;
  }
  std::size_t kept_half() const { return n_ / 2 + 2; }

  // Least trimmed squares from random triples; concentrate() refits and keeps the better half, until nothing improves.
  Indices trimmed_rows() const {
    Noise random(1);
    std::vector<Sample> best;
    for (std::size_t draw = 0; draw < kTriples; ++draw) {
      const std::size_t i = random.index(n_), j = random.index(n_), k = random.index(n_);
      if (i == j || j == k || i == k) continue;
      Sample sample = concentrate({i, j, k});
      const auto place = std::upper_bound(best.begin(), best.end(), sample.score,
                                          [](double score, const Sample& other) { return score < other.score; });
      if (place - best.begin() >= static_cast<std::ptrdiff_t>(kRefined)) continue;
      best.insert(place, std::move(sample));
      if (best.size() > kRefined) best.pop_back();
    }
    Sample winner;
    for (Sample& sample : best) {
      for (int step = 0; step < 30; ++step) {
        Sample next = concentrate(sample.rows);
        if (!(next.score < sample.score)) break;
        sample = std::move(next);
      }
      if (sample.score < winner.score) winner = std::move(sample);
    }
    // Estimates the noise: largest residual of the better half divided by its expected value for noise 1.
    const Unknowns at = closed_form(winner.rows);
    std::vector<double> turns, shifts;
    for (std::size_t i = 0; i < n_; ++i) {
      const Vector6 r = residual(at, i);
      turns.push_back(r.head<3>().squaredNorm()), shifts.push_back(r.tail<3>().squaredNorm());
    }
    const auto scale = [&](std::vector<double>& squares) {
      const double fraction = (static_cast<double>(kept_half()) - 0.5) / static_cast<double>(n_);
      return std::max(kFloor, std::sqrt(nth(squares, kept_half() - 1) / chi_squared_quantile(fraction, 3)));
    };
    return rows_within(at, scale(turns), scale(shifts), n_);
  }

  Indices rows_within(const Unknowns& at, double rotation, double translation, std::size_t used) const {
    const double freedom = std::max(1.0, 3 * static_cast<double>(used) - 0.5 * parameters_);
    const double limit = 3 * f_quantile(1 - 0.5 * options_.false_alarm / static_cast<double>(n_), 3, freedom);
    Indices rows;
    for (std::size_t i = 0; i < n_; ++i) {
      const Vector6 r = residual(at, i);
      if (r.head<3>().squaredNorm() <= limit * rotation * rotation &&
          r.tail<3>().squaredNorm() <= limit * translation * translation)
        rows.push_back(i);
    }
    return rows;
  }

  /// Noise covariance: two variances for few rows, all 21 elements for many.
  Matrix6 noise_of(const Unknowns& at, const Indices& rows) {
    Matrix6 sum = Matrix6::Zero();
    for (const std::size_t i : rows) {
      const Vector6 r = residual(at, i);
      sum += r * r.transpose();
    }
    const double count = static_cast<double>(rows.size()), freedom = std::max(1.0, 3 * count - 0.5 * parameters_);
    rotation_sigma_ = std::max(kFloor, std::sqrt(sum.topLeftCorner<3, 3>().trace() / freedom));
    translation_sigma_ = std::max(kFloor, std::sqrt(sum.bottomRightCorner<3, 3>().trace() / freedom));
    Vector6 variances;
    variances << Vector3d::Constant(rotation_sigma_ * rotation_sigma_),
        Vector3d::Constant(translation_sigma_ * translation_sigma_);
    const Matrix6 diagonal = variances.asDiagonal();
    if (rows.size() < kMinForFullNoise) return diagonal;
    return sum / (count - parameters_ / 6.0) + 1e-6 * diagonal;
  }

  void refine(Unknowns& at, const Indices& rows) {
    Matrix6 noise = noise_of(at, rows);
    for (int round = 0; round < 12; ++round) {
      const Matrix6 L = noise.llt().matrixL();
      const Matrix6 whitening = L.triangularView<Eigen::Lower>().solve(Matrix6::Identity());
      Vector6 x = Vector6::Zero(), z = Vector6::Zero();
      ceres::Problem problem;
      for (const std::size_t i : rows) {
        auto* row = new Row{A_[i], B_[i], at, whitening};
        if (options_.motions) {
          problem.AddResidualBlock(new ceres::AutoDiffCostFunction<Row, 6, 6>(row), nullptr, x.data());
        } else {
          problem.AddResidualBlock(new ceres::AutoDiffCostFunction<Row, 6, 6, 6>(row), nullptr, x.data(), z.data());
        }
      }
      ceres::Solver::Options settings;
      settings.linear_solver_type = ceres::DENSE_QR;
      settings.logging_type = ceres::SILENT;
      settings.function_tolerance = 1e-14;
      settings.parameter_tolerance = 1e-12;
      settings.gradient_tolerance = 1e-14;
      ceres::Solver::Summary summary;
      ceres::Solve(settings, &problem, &summary);
      at.X = {at.X.p + dvec3(x[3], x[4], x[5]), glm::normalize(turned_by(x.head<3>()) * at.X.R)};
      if (options_.motions) {
        at.Z = at.X;
      } else {
        at.Z = {at.Z.p + dvec3(z[3], z[4], z[5]), glm::normalize(turned_by(z.head<3>()) * at.Z.R)};
      }
      covariance_of(at, rows, whitening);
      const Matrix6 before = noise;
      noise = noise_of(at, rows);
      if ((noise - before).norm() <= 1e-6 * before.norm()) break;
    }
  }

  // Covariance (Jᵀ J)⁻¹ of the whitened residuals at the solution.
  void covariance_of(const Unknowns& at, const Indices& rows, const Matrix6& whitening) {
    using Jet = ceres::Jet<double, 12>;
    Eigen::MatrixXd H = Eigen::MatrixXd::Zero(parameters_, parameters_);
    for (const std::size_t i : rows) {
      const Row row{A_[i], B_[i], at, whitening};
      Jet x[6], z[6], r[6];
      for (int k = 0; k < 6; ++k) x[k] = Jet(0, k), z[k] = Jet(0, options_.motions ? k : 6 + k);
      row(x, z, r);
      Eigen::Matrix<double, 6, 12> J;
      for (int k = 0; k < 6; ++k) J.row(k) = r[k].v.transpose();
      H += (J.transpose() * J).topLeftCorner(parameters_, parameters_);
    }
    // The mean of an inverse Wishart distribution is too large by the factor ν / (ν - 7).
    const double nu = static_cast<double>(rows.size()) - parameters_ / 6.0;
    const double inflation = rows.size() < kMinForFullNoise ? 1 : nu / (nu - 7);
    // Divides rows and columns of H by the square roots of its diagonal, because the unknowns have different units.
    const Eigen::VectorXd scale = H.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    const Eigen::MatrixXd scaled = scale.asDiagonal() * H * scale.asDiagonal();
    covariance_ = inflation * scale.asDiagonal() * scaled.completeOrthogonalDecomposition().pseudoInverse().eval() *
                  scale.asDiagonal();
  }

  // Second moment of the arm's rotation vectors, frame S.
  void find_turns(const Indices& rows) {
    Matrix3d moment = Matrix3d::Zero();
    double count = 0;
    const auto add = [&](const dquat& R) {
      const Vector3d w = eigen(rotation_vector(R));
      moment += w * w.transpose();
      ++count;
    };
    if (options_.motions) {
      for (const std::size_t i : rows) add(A_[i].R);
    } else {
      const std::size_t step = 1 + rows.size() / 200;  // of many pairs, only a part is used
      for (std::size_t i = 0; i < rows.size(); i += step) {
        for (std::size_t j = i + step; j < rows.size(); j += step) add(glm::conjugate(A_[rows[i]].R) * A_[rows[j]].R);
      }
    }
    const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(moment / count);
    result_.main_turn = std::sqrt(std::max(0.0, solver.eigenvalues()[2]));
    result_.second_turn = std::sqrt(std::max(0.0, solver.eigenvalues()[1]));
    axis_ = solver.eigenvectors().col(2);
  }

  void refuse_turns(double noise) {
    const double min_main = std::max(kMinMainTurn, kTurnOverNoise * noise);
    const double min_second = std::max(kMinSecondTurn, kTurnOverNoise * noise);
    if (result_.main_turn < min_main) {
      result_.not_determined = fmt::format(
          "the arm turned by {:.2f}° rms only: neither rotation nor translation is determined; turn the "
          "stylus by 30° and more, about two axes",
          result_.main_turn / kDegree);
    } else if (result_.second_turn < min_second) {
      result_.not_determined = fmt::format(
          "all turns are about one axis, ({:.3f}, {:.3f}, {:.3f}) in S: the translation along it is not determined; "
          "turn the stylus about a second axis too, by 30° and more",
          axis_.x(), axis_.y(), axis_.z());
    }
  }

  void keep(const Unknowns& at, const Indices& rows) {
    result_.X = at.X, result_.Z = at.Z;
    for (Pose* pose : {&result_.X, &result_.Z}) {
      if (pose->R.w < 0) pose->R = -pose->R;
    }
    result_.inliers = rows;
    Indices all(n_);
    std::iota(all.begin(), all.end(), 0u);
    std::set_difference(all.begin(), all.end(), rows.begin(), rows.end(), std::back_inserter(result_.outliers));
    for (std::size_t i = 0; i < n_; ++i) {
      const Vector6 r = residual(at, i);
      result_.rotation_residuals.push_back(r.head<3>().norm());
      result_.translation_residuals.push_back(r.tail<3>().norm());
    }
    result_.rotation_sigma = rotation_sigma_, result_.translation_sigma = translation_sigma_;
    if (covariance_.size() == 0) return;
    const Matrix6 x = covariance_.topLeftCorner<6, 6>(), z = covariance_.bottomRightCorner<6, 6>();
    std::copy(x.data(), x.data() + 36, result_.X_covariance.begin());
    std::copy(z.data(), z.data() + 36, result_.Z_covariance.begin());
  }

  // Decides whether the result may be used; if not, stores the reason in result_.not_determined.
  void judge() {
    if (2 * result_.inliers.size() <= n_) {
      result_.not_determined =
          fmt::format("{} of {} rows agree on one pair of poses, expected more than half", result_.inliers.size(), n_);
      return;
    }
    if (result_.rotation_sigma > 0.25 * result_.main_turn) {
      // Most frequent mistake: the tracker poses are inverted. This mistake is reported if the inverse poses fit.
      std::vector<Pose> turned_round(B_.begin(), B_.end());
      for (Pose& pose : turned_round) pose = inverse(pose);
      Solver other(A_, turned_round, options_);
      Indices rows(n_);
      std::iota(rows.begin(), rows.end(), 0u);
      Unknowns at = other.closed_form(rows);
      other.noise_of(at, rows);
      const bool fits = other.rotation_sigma_ < 0.1 * result_.rotation_sigma;
      result_.not_determined = fmt::format(
          "the poses do not fit: {:.1f}° are left over per axis, the arm turned by {:.1f}° rms; {}",
          result_.rotation_sigma / kDegree, result_.main_turn / kDegree,
          fits ? "they do fit with every pose b inverted"
               : "check that both columns are of the same moments, and the order of the quaternions (w first)");
      return;
    }
    refuse_turns(result_.rotation_sigma);
  }

  std::span<const Pose> A_, B_;
  const HandEyeOptions& options_;
  std::size_t n_;
  int parameters_;
  Eigen::MatrixXd covariance_;
  // Noise per axis: of rotation (rad) and of translation (m).
  double rotation_sigma_ = 0, translation_sigma_ = 0;
  Vector3d axis_ = Vector3d::Zero();  // main axis of rotation in S
  HandEyeResult result_;
};

}  // namespace

HandEyeResult solve_hand_eye(std::span<const Pose> A, std::span<const Pose> B, const HandEyeOptions& options) {
  const char* what = options.motions ? "motions" : "poses";
  const std::size_t least = options.motions ? 2 : 3;
  if (A.size() != B.size()) {
    throw Error(fmt::format("hand-eye: found {} {} of the arm and {} of the tracker, expected as many", A.size(), what,
                            B.size()));
  }
  if (A.size() < least) throw Error(fmt::format("hand-eye: found {} {}, expected at least {}", A.size(), what, least));
  return Solver(A, B, options).solve();
}

}  // namespace typodont::calibration
