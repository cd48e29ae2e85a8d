#include "calibration/camera_solver.h"

#include <ceres/ceres.h>
#include <ceres/rotation.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>

#include "calibration/registration_solver.h"
#include "calibration/solver/eigen_math.h"
#include "engine/base/error.h"
#include "engine/base/voxels.h"

namespace typodont::calibration {

namespace {

// Parameter blocks: lens (fx fy cx cy k1 k2 p1 p2 k3), camera (W to K: angle-axis, translation), panel (angle-axis,
// middle, width, height), mirror normal, mirror offset, touched points. Derivatives are analytic; automatic derivatives
// took ten times as long.

using Eigen::Matrix3d;
using Eigen::Vector3d;
template <int Rows, int Columns>
using RowMajor = Eigen::Matrix<double, Rows, Columns, Columns == 1 ? Eigen::ColMajor : Eigen::RowMajor>;
// Writes a block of the Jacobian to the solver's memory.
template <int Rows, int Columns>
void put(double* block, const Eigen::Matrix<double, Rows, Columns>& values) {
  if (block) Eigen::Map<RowMajor<Rows, Columns>>{block} = values;
}

struct Turn {
  Matrix3d R;
  explicit Turn(const double* angle_axis) : w_(angle_axis[0], angle_axis[1], angle_axis[2]) {
    ceres::AngleAxisToRotationMatrix(angle_axis, R.data());  // R is column-major, as in Eigen
  }
  /// d(R p) / d(angle-axis): Gallego & Yezzi 2015, eq. 8.
  Matrix3d derivative(const Vector3d& p) const {
    const double w2 = w_.squaredNorm();
    if (w2 < 1e-16) return -cross_matrix(p);
    return -R * cross_matrix(p) * (w_ * w_.transpose() + (R.transpose() - Matrix3d::Identity()) * cross_matrix(w_)) /
           w2;
  }

 private:
  Vector3d w_;
};

// Position of the point p_W in the picture, pixels; its derivatives if they are requested.
struct Projection {
  double x = 0, y = 0;
  Eigen::Matrix<double, 2, 9> by_lens;
  Eigen::Matrix<double, 2, 6> by_camera;
  Eigen::Matrix<double, 2, 3> by_point;

  Projection(const double* lens, const double* camera, const Vector3d& p_W, bool derivatives) {
    const Turn turn(camera);
    const Vector3d p = turn.R * p_W + Vector3d(camera[3], camera[4], camera[5]);
    const double a = p.x() / p.z(), b = p.y() / p.z(), r2 = a * a + b * b;
    const double fx = lens[0], fy = lens[1], p1 = lens[6], p2 = lens[7];
    const double radial = 1 + r2 * (lens[4] + r2 * (lens[5] + r2 * lens[8]));
    const double seen_a = a * radial + 2 * p1 * a * b + p2 * (r2 + 2 * a * a);
    const double seen_b = b * radial + p1 * (r2 + 2 * b * b) + 2 * p2 * a * b;
    x = fx * seen_a + lens[2], y = fy * seen_b + lens[3];
    if (!derivatives) return;
    by_lens << seen_a, 0, 1, 0, fx * a * r2, fx * a * r2 * r2, fx * 2 * a * b, fx * (r2 + 2 * a * a),
        fx * a * r2 * r2 * r2,  //
        0, seen_b, 0, 1, fy * b * r2, fy * b * r2 * r2, fy * (r2 + 2 * b * b), fy * 2 * a * b, fy * b * r2 * r2 * r2;
    const double slope = lens[4] + r2 * (2 * lens[5] + r2 * 3 * lens[8]), mixed = 2 * (a * b * slope + p1 * a + p2 * b);
    Eigen::Matrix2d bent;
    bent << fx * (radial + 2 * a * a * slope + 2 * p1 * b + 6 * p2 * a), fx * mixed,  //
        fy * mixed, fy * (radial + 2 * b * b * slope + 6 * p1 * b + 2 * p2 * a);
    Eigen::Matrix<double, 2, 3> flat;
    flat << 1 / p.z(), 0, -a / p.z(), 0, 1 / p.z(), -b / p.z();
    const Eigen::Matrix<double, 2, 3> by_p = bent * flat;
    by_camera << by_p * turn.derivative(p_W), by_p;
    by_point = by_p * turn.R;
  }
};

struct PanelSpot {
  Vector3d p_W;
  Eigen::Matrix<double, 3, 8> by_panel;

  PanelSpot(const double* panel, double u, double v, bool derivatives) {
    const Turn turn(panel);
    const Vector3d local((u - 0.5) * panel[6], (v - 0.5) * panel[7], 0);
    p_W = turn.R * local + Vector3d(panel[3], panel[4], panel[5]);
    if (derivatives)
      by_panel << turn.derivative(local), Matrix3d::Identity(), (u - 0.5) * turn.R.col(0), (v - 0.5) * turn.R.col(1);
  }
};

// In all cost functions, the first parameter blocks are lens and camera; residuals: pixels × `weight` (1/σ).
struct Seen {
  double x, y, weight;
  void residual(const Projection& seen, double* r) const { r[0] = (seen.x - x) * weight, r[1] = (seen.y - y) * weight; }
  void first_two(const Projection& seen, double** jacobians) const {
    put<2, 9>(jacobians[0], weight * seen.by_lens);
    put<2, 6>(jacobians[1], weight * seen.by_camera);
  }
};

struct PanelSeen : ceres::SizedCostFunction<2, 9, 6, 8> {
  PanelSeen(const PanelPoint& corner, const Seen& at) : corner_(corner), at_(at) {}
  bool Evaluate(const double* const* blocks, double* r, double** jacobians) const override {
    const PanelSpot spot(blocks[2], corner_.u, corner_.v, jacobians);
    const Projection seen(blocks[0], blocks[1], spot.p_W, jacobians);
    at_.residual(seen, r);
    if (!jacobians) return true;
    at_.first_two(seen, jacobians);
    put<2, 8>(jacobians[2], at_.weight * seen.by_point * spot.by_panel);
    return true;
  }

 private:
  PanelPoint corner_;
  Seen at_;
};

struct ReflectionSeen : ceres::SizedCostFunction<2, 9, 6, 8, 3, 1> {
  ReflectionSeen(const PanelPoint& corner, const Seen& at) : corner_(corner), at_(at) {}
  bool Evaluate(const double* const* blocks, double* r, double** jacobians) const override {
    const PanelSpot spot(blocks[2], corner_.u, corner_.v, jacobians);
    const Vector3d n(blocks[3][0], blocks[3][1], blocks[3][2]);
    const double above = n.dot(spot.p_W) - blocks[4][0];
    const Projection seen(blocks[0], blocks[1], spot.p_W - 2 * above * n, jacobians);
    at_.residual(seen, r);
    if (!jacobians) return true;
    at_.first_two(seen, jacobians);
    const Eigen::Matrix<double, 2, 3> by_image = at_.weight * seen.by_point;
    put<2, 8>(jacobians[2], (by_image - 2 * (by_image * n) * n.transpose()) * spot.by_panel);
    put<2, 3>(jacobians[3], -2 * ((by_image * n) * spot.p_W.transpose() + above * by_image));
    put<2, 1>(jacobians[4], 2 * by_image * n);
    return true;
  }

 private:
  PanelPoint corner_;
  Seen at_;
};

struct PointSeen : ceres::SizedCostFunction<2, 9, 6, 3> {
  explicit PointSeen(const Seen& at) : at_(at) {}
  bool Evaluate(const double* const* blocks, double* r, double** jacobians) const override {
    const Projection seen(blocks[0], blocks[1], Vector3d(blocks[2][0], blocks[2][1], blocks[2][2]), jacobians);
    at_.residual(seen, r);
    if (!jacobians) return true;
    at_.first_two(seen, jacobians);
    put<2, 3>(jacobians[2], at_.weight * seen.by_point);
    return true;
  }

 private:
  Seen at_;
};

struct PointTouched : ceres::SizedCostFunction<3, 3> {
  PointTouched(const dvec3& p, double weight) : p_(p), weight_(weight) {}
  bool Evaluate(const double* const* blocks, double* r, double** jacobians) const override {
    for (int i = 0; i < 3; ++i) r[i] = (blocks[0][i] - p_[i]) * weight_;
    if (jacobians) put<3, 3>(jacobians[0], weight_ * Matrix3d::Identity());
    return true;
  }

 private:
  dvec3 p_;
  double weight_;
};

using Planar = std::vector<std::array<double, 4>>;  // positions on a plane in m, and in the picture in pixels

// Homography by direct linear transform with normalised coordinates.
Eigen::Matrix3d homography(const Planar& points) {
  Eigen::Vector4d mean = Eigen::Vector4d::Zero(), spread = Eigen::Vector4d::Zero();
  for (const auto& p : points) mean += Eigen::Vector4d(p[0], p[1], p[2], p[3]) / static_cast<double>(points.size());
  for (const auto& p : points)
    spread += (Eigen::Vector4d(p[0], p[1], p[2], p[3]) - mean).cwiseAbs() / static_cast<double>(points.size());
  const double a = std::max(spread[0] + spread[1], 1e-12), b = std::max(spread[2] + spread[3], 1e-12);
  Eigen::MatrixXd A(2 * static_cast<Eigen::Index>(points.size()), 9);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double x = (points[i][0] - mean[0]) / a, y = (points[i][1] - mean[1]) / a;
    const double u = (points[i][2] - mean[2]) / b, v = (points[i][3] - mean[3]) / b;
    A.row(2 * static_cast<Eigen::Index>(i)) << x, y, 1, 0, 0, 0, -u * x, -u * y, -u;
    A.row(2 * static_cast<Eigen::Index>(i) + 1) << 0, 0, 0, x, y, 1, -v * x, -v * y, -v;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(A.transpose() * A);
  const Eigen::VectorXd h = eigen.eigenvectors().col(0);
  Eigen::Matrix3d H, from, to;
  H << h[0], h[1], h[2], h[3], h[4], h[5], h[6], h[7], h[8];
  from << 1 / a, 0, -mean[0] / a, 0, 1 / a, -mean[1] / a, 0, 0, 1;
  to << b, 0, mean[2], 0, b, mean[3], 0, 0, 1;
  return to * H * from;
}

// Pose of a plane relative to the camera (Zhang 2000, section 3.1).
Pose plane_pose(const Eigen::Matrix3d& H, double f, double cx, double cy) {
  Eigen::Matrix3d K;
  K << f, 0, cx, 0, f, cy, 0, 0, 1;
  Eigen::Matrix3d B = K.inverse() * H;
  double scale = 2 / (B.col(0).norm() + B.col(1).norm());
  if (B(2, 2) < 0) scale = -scale;  // the solution in front of the camera
  B *= scale;
  Eigen::Matrix3d R;
  R.col(0) = B.col(0), R.col(1) = B.col(1), R.col(2) = B.col(0).cross(B.col(1));
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(R, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Quaterniond q(Eigen::Matrix3d(svd.matrixU() * svd.matrixV().transpose()));
  return {dvec3(B(0, 2), B(1, 2), B(2, 2)), dquat(q.w(), q.x(), q.y(), q.z())};
}

std::array<double, 6> camera_block(const Pose& X_KW) {
  const double q[4] = {X_KW.R.w, X_KW.R.x, X_KW.R.y, X_KW.R.z};
  std::array<double, 6> block{};
  ceres::QuaternionToAngleAxis(q, block.data());
  block[3] = X_KW.p.x, block[4] = X_KW.p.y, block[5] = X_KW.p.z;
  return block;
}

dquat rotation(const double* angle_axis) {
  double q[4];
  ceres::AngleAxisToQuaternion(angle_axis, q);
  return {q[0], q[1], q[2], q[3]};
}

// Covariance of the last `wanted` unknowns in `order`. Returns false if the problem does not determine all of them.
bool covariance_of_last(ceres::Problem& problem, const std::vector<double*>& order, Eigen::Index wanted,
                        Eigen::MatrixXd& covariance) {
  ceres::Problem::EvaluateOptions options;
  options.parameter_blocks = order;
  ceres::CRSMatrix J;
  if (!problem.Evaluate(options, nullptr, nullptr, nullptr, &J)) return false;
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(J.num_cols, J.num_cols);
  for (std::size_t row = 0; row < static_cast<std::size_t>(J.num_rows); ++row) {
    for (int k = J.rows[row]; k < J.rows[row + 1]; ++k) {
      const auto a = static_cast<std::size_t>(k);
      for (int l = J.rows[row]; l <= k; ++l) {
        const auto b = static_cast<std::size_t>(l);
        A(std::max(J.cols[a], J.cols[b]), std::min(J.cols[a], J.cols[b])) += J.values[a] * J.values[b];
      }
    }
  }
  if (!(A.diagonal().minCoeff() > 0)) return false;
  const Eigen::VectorXd scale = A.diagonal().cwiseSqrt().cwiseInverse();
  A = scale.asDiagonal() * A * scale.asDiagonal();
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>, Eigen::Lower> factor(A);  // factorises in place
  if (factor.info() != Eigen::Success || !(A.diagonal().minCoeff() > 1e-7)) return false;
  const Eigen::MatrixXd last = A.bottomRightCorner(wanted, wanted).triangularView<Eigen::Lower>();
  const Eigen::MatrixXd inverse = last.triangularView<Eigen::Lower>().solve(Eigen::MatrixXd::Identity(wanted, wanted));
  covariance = scale.tail(wanted).asDiagonal() * (inverse.transpose() * inverse) * scale.tail(wanted).asDiagonal();
  return true;
}

}  // namespace

Pixel project(const CameraIntrinsics& camera, const Pose& X_WK, const dvec3& p_W) {
  const double lens[9] = {camera.fx,
                          camera.fy,
                          camera.cx,
                          camera.cy,
                          camera.distortion[0],
                          camera.distortion[1],
                          camera.distortion[2],
                          camera.distortion[3],
                          camera.distortion[4]};
  const auto block = camera_block(inverse(X_WK));
  const Projection seen(lens, block.data(), eigen(p_W), false);
  return {seen.x, seen.y};
}

CameraResult solve_camera(std::span<const Sighting> sightings, int width_px, int height_px, const Panel& start,
                          const CameraOptions& options) {
  const auto started = std::chrono::steady_clock::now();
  CameraResult result;
  std::map<int, std::vector<const Sighting*>> pictures;
  std::map<dvec3, std::array<double, 3>, LessByAxes> touched;
  bool panel_seen = false, mirror_seen = false;
  for (const Sighting& s : sightings) {
    pictures[s.picture].push_back(&s);
    if (s.on == SeenOn::kTouchedPoint) touched[s.touched_W] = {s.touched_W.x, s.touched_W.y, s.touched_W.z};
    panel_seen = panel_seen || s.on == SeenOn::kPanel;
    mirror_seen = mirror_seen || s.on == SeenOn::kPanelInMirror;
  }
  if (!panel_seen) throw Error("camera: found no sighting of the panel itself, expected at least one picture of it");
  result.width = glm::length(start.lower_right - start.lower_left),
  result.height = glm::length(start.upper_left - start.lower_left);

  // If the touched points lie in a plane, this plane gives the first estimate of the cameras.
  std::vector<dvec3> points;
  for (const auto& [key, value] : touched) points.push_back(key);
  if (points.size() < 4) {
    result.not_determined = fmt::format(
        "{} touched points in the pictures: at least four, not on one line, tie the camera to the arm", points.size());
    return result;
  }
  dvec3 middle(0);
  for (const dvec3& p : points) middle += p / static_cast<double>(points.size());
  const auto axes = eigen_of(scatter_about(middle, points));
  if (axes.eigenvalues()[1] < 1e-4 * axes.eigenvalues()[2]) {
    result.not_determined = "the touched points lie on one line: the turn about it is not determined";
    return result;
  }
  Eigen::Matrix3d frame;
  frame.col(0) = axes.eigenvectors().col(2), frame.col(1) = axes.eigenvectors().col(1),
  frame.col(2) = frame.col(0).cross(frame.col(1));
  const Eigen::Quaterniond fq(frame);
  // Plane of the touched points as frame B.
  const Pose X_WB{middle, {fq.w(), fq.x(), fq.y(), fq.z()}};
  const Pose X_BW = inverse(X_WB);

  const auto planar = [&](const std::vector<const Sighting*>& seen, SeenOn on) {
    Planar list;
    for (const Sighting* s : seen) {
      if (s->on != on) continue;
      const dvec3 p = X_BW * s->touched_W;
      if (on == SeenOn::kTouchedPoint)
        list.push_back({p.x, p.y, s->px, s->py});
      else
        list.push_back({(s->corner.u - 0.5) * result.width, (s->corner.v - 0.5) * result.height, s->px, s->py});
    }
    return list;
  };
  // First focal length: h1ᵀ ω h2 = 0 and h1ᵀ ω h1 = h2ᵀ ω h2 with ω = diag(1/f², 1/f², 1) are linear in 1/f² (principal
  // point in the centre, square pixels).
  const double cx = 0.5 * (width_px - 1), cy = 0.5 * (height_px - 1);
  double aa = 0, ab = 0;
  for (const auto& [id, seen] : pictures) {
    for (const SeenOn on : {SeenOn::kTouchedPoint, SeenOn::kPanel, SeenOn::kPanelInMirror}) {
      const Planar list = planar(seen, on);
      if (list.size() < 6) continue;
      Eigen::Matrix3d H = homography(list);
      H /= H.col(0).norm();
      for (int c = 0; c < 3; ++c) H(0, c) -= cx * H(2, c), H(1, c) -= cy * H(2, c);
      const double first = H(0, 0) * H(0, 1) + H(1, 0) * H(1, 1);
      const double second = H(0, 0) * H(0, 0) + H(1, 0) * H(1, 0) - H(0, 1) * H(0, 1) - H(1, 1) * H(1, 1);
      const double b1 = -H(2, 0) * H(2, 1), b2 = -(H(2, 0) * H(2, 0) - H(2, 1) * H(2, 1));
      aa += first * first + second * second, ab += first * b1 + second * b2;
    }
  }
  double f = aa > 0 && ab > 0 ? std::sqrt(aa / ab) : 1.2 * width_px;
  if (!(f > 0.3 * width_px && f < 10 * width_px)) f = 1.2 * width_px;

  // First estimates: first the cameras of pictures with touched points, from these the panel, from the panel the other
  // cameras.
  std::map<int, Pose> X_KW;
  std::optional<Pose> X_WP;
  for (const auto& [id, seen] : pictures) {
    const Planar board = planar(seen, SeenOn::kTouchedPoint);
    if (board.size() >= 4) X_KW[id] = plane_pose(homography(board), f, cx, cy) * X_BW;
  }
  for (const auto& [id, seen] : pictures) {
    const Planar panel = planar(seen, SeenOn::kPanel);
    if (!X_WP && X_KW.count(id) && panel.size() >= 4)
      X_WP = inverse(X_KW[id]) * plane_pose(homography(panel), f, cx, cy);
  }
  if (!X_WP) {
    result.not_determined = "no picture shows the panel together with at least four touched points";
    return result;
  }
  for (const auto& [id, seen] : pictures) {
    const Planar panel = planar(seen, SeenOn::kPanel);
    if (!X_KW.count(id) && panel.size() >= 4) X_KW[id] = plane_pose(homography(panel), f, cx, cy) * inverse(*X_WP);
  }
  std::optional<MirrorPlane> mirror;
  for (const auto& [id, seen] : pictures) {
    const Planar image = planar(seen, SeenOn::kPanelInMirror);
    if (mirror || !X_KW.count(id) || image.size() < 4) continue;
    // The mirror is half-way between panel and mirror image.
    const Pose X_WI = inverse(X_KW[id]) * plane_pose(homography(image), f, cx, cy);
    const dvec3 direction = X_WI.p - X_WP->p;
    if (glm::length(direction) < 1e-3) continue;
    const dvec3 n = glm::normalize(-direction);
    mirror = MirrorPlane{n, glm::dot(n, 0.5 * (X_WI.p + X_WP->p))};
  }

  double lens[9] = {f, f, cx, cy, 0, 0, 0, 0, 0};
  std::map<int, std::array<double, 6>> cameras;
  for (const auto& [id, X] : X_KW) cameras[id] = camera_block(X);
  const auto panel_start = camera_block(*X_WP);
  double panel[8] = {panel_start[0], panel_start[1], panel_start[2], panel_start[3],
                     panel_start[4], panel_start[5], result.width,   result.height};
  double normal[3] = {0, 1, 0}, offset = 0;
  if (mirror)
    normal[0] = mirror->normal.x, normal[1] = mirror->normal.y, normal[2] = mirror->normal.z, offset = mirror->offset;

  ceres::Problem problem;
  const double weight = 1 / options.pixel_sigma;
  int used = 0;
  for (const Sighting& s : sightings) {
    if (!cameras.count(s.picture)) continue;
    double* camera = cameras[s.picture].data();
    auto* loss = new ceres::CauchyLoss(4);
    const Seen at{s.px, s.py, weight};
    if (s.on == SeenOn::kTouchedPoint)
      problem.AddResidualBlock(new PointSeen(at), loss, lens, camera, touched[s.touched_W].data());
    else if (s.on == SeenOn::kPanel)
      problem.AddResidualBlock(new PanelSeen(s.corner, at), loss, lens, camera, panel);
    else if (mirror)
      problem.AddResidualBlock(new ReflectionSeen(s.corner, at), loss, lens, camera, panel, normal, &offset);
    else {
      delete loss;
      continue;
    }
    ++used;
  }
  for (auto& [key, point] : touched) {
    problem.AddResidualBlock(new PointTouched(key, 1 / options.touch_sigma), nullptr, point.data());
  }
  if (mirror) problem.SetManifold(normal, new ceres::SphereManifold<3>);
  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::DENSE_SCHUR;
  solver.max_num_iterations = 200;
  solver.parameter_tolerance = 1e-14, solver.gradient_tolerance = 1e-14;
  solver.logging_type = ceres::SILENT;
  // First solves without lens distortion: far from the solution, distortion would compensate for other errors.
  std::vector<int> distortion{4, 5, 6, 7, 8};
  problem.SetManifold(lens, new ceres::SubsetManifold(9, distortion));
  ceres::Solver::Summary summary;
  // Large trust region, because the first estimate is good; a smaller one doubled the number of iterations.
  solver.initial_trust_region_radius = 1e8;
  solver.function_tolerance = 0.1;  // low accuracy, because this is only an initial solution
  ceres::Solve(solver, &problem, &summary);
  problem.SetManifold(lens, nullptr);
  solver.function_tolerance = 1e-8;  // relative change of chi-squared
  ceres::Solve(solver, &problem, &summary);

  // The wanted unknowns come last, so that only the last block of the Cholesky factor is needed. (Ceres' own covariance
  // took as long as the solution.)
  std::vector<double*> order;
  for (auto& [key, point] : touched) order.push_back(point.data());
  for (auto& [id, camera] : cameras) order.push_back(camera.data());
  order.push_back(lens), order.push_back(panel);
  if (mirror) order.push_back(normal), order.push_back(&offset);
  const Eigen::Index wanted = 9 + 8 + (mirror ? 3 : 0);
  Eigen::MatrixXd C;
  if (!covariance_of_last(problem, order, wanted, C)) {
    result.not_determined =
        "the pictures do not determine camera, panel and mirror together: take more, from more directions";
    return result;
  }
  const auto variance = [&](Eigen::Index i) { return C(i, i); };
  const Eigen::MatrixXd P = C.block<8, 8>(9, 9);
  result.tilt_sigma = std::sqrt(std::max({P(0, 0), P(1, 1), P(2, 2)}));
  result.centre_sigma = {std::sqrt(P(3, 3)), std::sqrt(P(4, 4)), std::sqrt(P(5, 5))};
  result.width = panel[6], result.height = panel[7], result.width_sigma = std::sqrt(P(6, 6)),
  result.height_sigma = std::sqrt(P(7, 7));
  result.camera = {lens[0], lens[1], lens[2], lens[3], {lens[4], lens[5], lens[6], lens[7], lens[8]}};
  const auto sd = [&](Eigen::Index i) { return std::sqrt(variance(i)); };
  result.camera_sigma = {sd(0), sd(1), sd(2), sd(3), {sd(4), sd(5), sd(6), sd(7), sd(8)}};
  const Pose X{dvec3(panel[3], panel[4], panel[5]), rotation(panel)};
  const auto corner = [&](double x, double y) { return X * dvec3(x * panel[6], y * panel[7], 0); };
  result.panel = {corner(-0.5, -0.5), corner(0.5, -0.5), corner(-0.5, 0.5)};
  if (mirror) {
    // Tangent vectors of the mirror's normal.
    RowMajor<3, 2> tangent;
    ceres::SphereManifold<3>().PlusJacobian(normal, tangent.data());
    const Matrix3d N = tangent * C.block<2, 2>(17, 17) * tangent.transpose();
    result.mirror = MirrorPlane{{normal[0], normal[1], normal[2]}, offset};
    result.mirror_tilt_sigma = std::sqrt(N.diagonal().maxCoeff());
    result.mirror_offset_sigma = std::sqrt(variance(19));
  }
  for (const auto& [id, camera] : cameras) {
    result.X_WK.push_back(inverse(Pose{dvec3(camera[3], camera[4], camera[5]), rotation(camera.data())}));
  }
  double squares = 0;
  for (const Sighting& s : sightings) {
    if (!cameras.count(s.picture) || (s.on == SeenOn::kPanelInMirror && !mirror)) continue;
    Vector3d p = s.on == SeenOn::kTouchedPoint ? Vector3d(touched[s.touched_W].data())
                                               : PanelSpot(panel, s.corner.u, s.corner.v, false).p_W;
    if (s.on == SeenOn::kPanelInMirror) {
      p = eigen(result.mirror->reflect(vec(p)));
    }
    const Projection seen(lens, cameras[s.picture].data(), p, false);
    const double r2 = std::pow(seen.x - s.px, 2) + std::pow(seen.y - s.py, 2);
    result.worst_px = std::max(result.worst_px, std::sqrt(r2));
    if (r2 > 25 * 2 * options.pixel_sigma * options.pixel_sigma) {
      ++result.outliers;
      continue;
    }
    squares += r2 / 2;
  }
  result.rms_px = std::sqrt(squares / std::max(1, used - result.outliers));
  if (mirror_seen && !mirror) {
    result.not_determined =
        "the panel's reflection is in no picture whose place is known: the mirror is not determined";
  }
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - started).count();
  return result;
}

}  // namespace typodont::calibration
