#include "calibration/joint_solver.h"

#include <ceres/jet.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <numeric>

#include "calibration/solver/eigen_math.h"
#include "engine/base/error.h"
namespace typodont::calibration {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using Columns = Eigen::Matrix<double, 3, Eigen::Dynamic>;

enum Kind { kArm, kPanel, kMirror, kEyes, kTouch, kKinds };
constexpr const char* kKindNames[kKinds] = {"arm", "panel", "mirror", "eyes", "touch"};
constexpr int kSizes[kKinds] = {3, 3, 1, 2, 3};

dquat rotation_vector(const dvec3& v) {
  return glm::normalize(dquat(1, 0.5 * v.x, 0.5 * v.y, 0.5 * v.z));
}
/// Derivative d(R p)/dv of a rotated vector, R = rotation_vector(v), `turned` = R p. With the Gibbs vector g = v/2: ω =
/// 2/(1+g²) (ġ + g × ġ) (Bauchau & Trainelli 2003, eq. 61).
Matrix3d turn_derivative(const dvec3& v, const dvec3& turned) {
  const dvec3 g = 0.5 * v;
  return -cross_matrix(turned) * (Matrix3d::Identity() + cross_matrix(g)) / (1 + glm::dot(g, g));
}

/// closest_point() and its derivatives with respect to left eye, left dot, right eye, right dot.
dvec3 closest_point(const std::array<dvec3, 4>& points, Eigen::Matrix<double, 3, 12>& derivative) {
  using Jet = ceres::Jet<double, 12>;
  using Vector = Eigen::Matrix<Jet, 3, 1>;
  Vector p[4];
  for (int k = 0; k < 4; ++k) {
    for (int i = 0; i < 3; ++i) p[k][i] = Jet(points[static_cast<std::size_t>(k)][i], 3 * k + i);
  }
  const Vector d = (p[1] - p[0]).normalized(), e = (p[3] - p[2]).normalized(), w = p[0] - p[2];
  const Jet de = d.dot(e), dw = d.dot(w), ew = e.dot(w), det = 1.0 - de * de;
  const Vector middle = 0.5 * (p[0] + d * ((de * ew - dw) / det) + p[2] + e * ((ew - de * dw) / det));
  dvec3 at;
  for (int i = 0; i < 3; ++i) at[i] = middle[i].a, derivative.row(i) = middle[i].v.transpose();
  return at;
}

dvec3 triple(const VectorXd& x, Eigen::Index at) {
  return {x[at], x[at + 1], x[at + 2]};
}

// Order of the unknowns, which are offsets from the first estimate, so that the prior has mean zero.
struct Layout {
  Eigen::Index arm = 0, panel = 18, mirror = 26, eyes = 29, offset = 35, places = 38, size = 38;
};

class Model {
 public:
  Model(const BenchState& bench, const Captures& captures) : bench_(bench), captures_(captures) {
    arm0_ = to_vector(bench.arm);
    std::map<int, std::vector<std::size_t>> groups;
    for (std::size_t i = 0; i < captures.arm.size(); ++i) groups[captures.arm[i].group].push_back(i);
    for (const auto& [id, members] : groups) {
      std::vector<dvec3> known, tips;
      for (const std::size_t i : members) {
        known.push_back(captures.arm[i].known.value_or(dvec3(0)));
        tips.push_back(tip_position(bench.arm, captures.arm[i].reading));
      }
      place_[id] = {layout_.size, fit_rigid(known, tips)};
      layout_.size += captures.arm[members.front()].known ? 6 : 3;
    }
    const auto add = [&](Kind kind, std::size_t index) { blocks_.push_back({kind, index}); };
    for (std::size_t i = 0; i < captures.arm.size(); ++i) add(kArm, i);
    for (std::size_t i = 0; i < captures.marks.size(); ++i) add(kPanel, i);
    for (std::size_t i = 0; bench.rig.mirror && i < captures.mirror.size(); ++i) add(kMirror, i);
    for (std::size_t i = 0; i < captures.eyes.size(); ++i) add(kEyes, i);
    for (std::size_t i = 0; i < captures.registration.size(); ++i) {
      if (captures.registration[i].dots) add(kTouch, i);
    }
    // Frame of the panel, and axes of the mirror's tilt.
    const Panel& p = bench.rig.panel;
    right_ = p.lower_right - p.lower_left, up_ = p.upper_left - p.lower_left;
    width_ = glm::length(right_), height_ = glm::length(up_);
    center_ = p.at(0.5, 0.5);
    if (bench.rig.mirror) {
      const dvec3& n = bench.rig.mirror->normal;
      tilt_a_ = glm::normalize(glm::cross(n, std::abs(n.x) < 0.9 ? dvec3(1, 0, 0) : dvec3(0, 1, 0)));
      tilt_b_ = glm::cross(n, tilt_a_);
      dvec3 sum(0);
      for (const Touch& t : captures.mirror) sum += bench.rig.X_WH * t.at(bench.arm);
      pivot_ =
          captures.mirror.empty() ? n * bench.rig.mirror->offset : sum / static_cast<double>(captures.mirror.size());
      pivot_ -= n * (glm::dot(n, pivot_) - bench.rig.mirror->offset);
    }
  }

  const Layout& layout() const { return layout_; }
  std::size_t blocks() const { return blocks_.size(); }
  Kind kind(std::size_t block) const { return blocks_[block].kind; }

  VectorXd scale() const {
    VectorXd scale = VectorXd::Constant(layout_.size, 0.02);
    const auto arm = arm_parameter_scales();
    for (std::size_t i = 0; i < arm.size(); ++i) scale[static_cast<Eigen::Index>(i)] = arm[i];
    scale.segment<3>(layout_.panel + 3).setConstant(0.1);  // rad, plausible error of the panel's rotation
    scale.segment<2>(layout_.mirror).setConstant(0.1);     // rad, plausible error of the mirror's tilt
    return scale;
  }

  ArmGeometry arm(const VectorXd& x) const {
    auto v = arm0_;
    for (std::size_t i = 0; i < v.size(); ++i) v[i] += x[layout_.arm + static_cast<Eigen::Index>(i)];
    return to_geometry(v);
  }
  Panel panel(const VectorXd& x) const {
    const dquat R = rotation_vector(triple(x, layout_.panel + 3));
    const dvec3 center = center_ + triple(x, layout_.panel);
    const dvec3 right = R * right_ * (1 + x[layout_.panel + 6] / width_),
                up = R * up_ * (1 + x[layout_.panel + 7] / height_);
    const dvec3 corner = center - 0.5 * right - 0.5 * up;
    return {corner, corner + right, corner + up};
  }
  std::optional<MirrorPlane> mirror(const VectorXd& x) const {
    if (!bench_.rig.mirror) return std::nullopt;
    const dvec3 n =
        glm::normalize(bench_.rig.mirror->normal + x[layout_.mirror] * tilt_a_ + x[layout_.mirror + 1] * tilt_b_);
    return MirrorPlane{n, glm::dot(n, pivot_) + x[layout_.mirror + 2]};
  }
  dvec3 eye(const VectorXd& x, bool right) const {
    return (right ? bench_.rig.eyes.right_eye() : bench_.rig.eyes.left_eye()) +
           triple(x, layout_.eyes + (right ? 3 : 0));
  }
  EyePair eyes(const VectorXd& x) const {
    const dvec3 l = eye(x, false), r = eye(x, true);
    return {0.5 * (l + r), glm::length(r - l), glm::normalize(r - l)};
  }

  /// Indices of the unknowns on which a touch depends.
  std::vector<Eigen::Index> unknowns(std::size_t block) const {
    std::vector<Eigen::Index> list;
    const auto range = [&](Eigen::Index first, Eigen::Index count) {
      for (Eigen::Index i = 0; i < count; ++i) list.push_back(first + i);
    };
    const auto [kind, index] = blocks_[block];
    if (!captures_.arm.empty()) range(layout_.arm, 18);
    if (kind == kArm) {
      const auto& capture = captures_.arm[index];
      range(place_.at(capture.group).first, capture.known ? 6 : 3);
    }
    if (kind == kPanel || kind == kEyes || kind == kTouch) range(layout_.panel, 8);
    if (bench_.rig.mirror && (kind == kMirror || kind == kEyes || kind == kTouch)) range(layout_.mirror, 3);
    if (kind == kEyes) range(layout_.eyes + (captures_.eyes[index].right ? 3 : 0), 3);
    if (kind == kTouch) range(layout_.eyes, 6), range(layout_.offset, 3);
    return list;
  }

  /// Residuals of a touch and their derivatives, in the order of unknowns(block).
  void evaluate(const VectorXd& x, std::size_t block, double* r, Columns& J) const {
    const auto [kind, index] = blocks_[block];
    const ArmGeometry geometry = arm(x);
    J.setZero();
    const Eigen::Index after_arm = captures_.arm.empty() ? 0 : 18;
    const auto put = [&](const dvec3& e) { r[0] = e.x, r[1] = e.y, r[2] = e.z; };
    const auto by_arm = [&](const ArmReading& reading, const dquat& R) {
      const auto slopes = tip_derivatives(geometry, reading);
      for (Eigen::Index p = 0; p < 18; ++p) J.col(p) = eigen(R * slopes[static_cast<std::size_t>(p)]);
    };
    if (kind == kArm) {
      const auto& capture = captures_.arm[index];
      const auto& [at, X0] = place_.at(capture.group);
      dvec3 target = X0.p + triple(x, at);
      by_arm(capture.reading, dquat(1, 0, 0, 0));
      J.middleCols<3>(after_arm) = -Matrix3d::Identity();
      if (capture.known) {
        const dvec3 turn = triple(x, at + 3), turned = rotation_vector(turn) * X0.rotate(*capture.known);
        target += turned;
        J.middleCols<3>(after_arm + 3) = -turn_derivative(turn, turned);
      }
      put(tip_position(geometry, capture.reading) - target);
      return;
    }
    const auto held = [&](const Touch& touch) {
      if (touch.reading && after_arm > 0) by_arm(*touch.reading, bench_.rig.X_WH.R);
      return bench_.rig.X_WH * touch.at(geometry);
    };
    if (kind == kPanel) {
      const auto& capture = captures_.marks[index];
      put(held(capture.touch) - panel(x).at(capture.mark.u, capture.mark.v));
      J.middleCols<8>(after_arm) = -by_panel(x, capture.mark);
      return;
    }
    if (kind == kMirror) {
      const MirrorPlane plane = *mirror(x);
      const dvec3 p = held(captures_.mirror[index]);
      r[0] = glm::dot(plane.normal, p) - plane.offset;
      J.row(0) = (eigen(plane.normal).transpose() * J).eval();
      const auto tilts = by_tilt(x);
      for (Eigen::Index k = 0; k < 2; ++k)
        J(0, after_arm + k) = glm::dot(tilts[static_cast<std::size_t>(k)], p - pivot_);
      J(0, after_arm + 2) = -1;
      return;
    }
    const Panel screen = panel(x);
    const auto plane = mirror(x);
    const Eigen::Index seen = plane ? 11 : 8;  // number of unknowns that influence where a dot appears
    const auto appears = [&](const PanelPoint& dot, Columns& D) {
      const dvec3 p = screen.at(dot.u, dot.v);
      D.resize(3, seen);
      D.leftCols<8>() = by_panel(x, dot);
      if (!plane) return p;
      const Vector3d n = eigen(plane->normal);
      const double above = glm::dot(plane->normal, p) - plane->offset;
      D.leftCols<8>() -= (2 * n * (n.transpose() * D.leftCols<8>())).eval();
      const auto tilts = by_tilt(x);
      for (Eigen::Index k = 0; k < 2; ++k) {
        const dvec3& tilt = tilts[static_cast<std::size_t>(k)];
        D.col(8 + k) = -2 * (above * eigen(tilt) + n * glm::dot(tilt, p - pivot_));
      }
      D.col(10) = 2 * n;
      return plane->reflect(p);
    };
    if (kind == kEyes) {
      const auto& capture = captures_.eyes[index];
      Columns D;
      const dvec3 from = eye(x, capture.right), dot = appears(capture.dot, D), e = held(capture.touch) - from;
      const double distance = glm::length(dot - from);
      const dvec3 sight = (dot - from) / distance, fixed(0.36, 0.48, 0.8), normal = glm::cross(sight, fixed);
      const dvec3 across = glm::normalize(normal), other = glm::cross(sight, across);
      r[0] = glm::dot(across, e), r[1] = glm::dot(other, e);
      const auto unit = [](const dvec3& v, double length) -> Matrix3d {
        return (Matrix3d::Identity() - eigen(v) * eigen(v).transpose()) / length;
      };
      // If the line of sight rotates, its perpendicular axes rotate too; if the eye moves, the vector to the tip
      // changes.
      const Matrix3d by_sight = unit(across, glm::length(normal)) * -cross_matrix(fixed);
      Eigen::Matrix<double, 2, 3> by_e, turned;
      by_e << eigen(across).transpose(), eigen(other).transpose();
      turned << eigen(e).transpose() * by_sight,
          eigen(e).transpose() * (cross_matrix(sight) * by_sight - cross_matrix(across));
      turned *= unit(sight, distance);
      J.topRows<2>().leftCols(after_arm) = (by_e * J.leftCols(after_arm)).eval();
      J.topRows<2>().middleCols(after_arm, seen) = turned * D;
      J.topRows<2>().middleCols<3>(after_arm + seen) = -turned - by_e;
      return;
    }
    const auto& capture = captures_.registration[index];
    Columns left, right;
    Eigen::Matrix<double, 3, 12> C;
    const dvec3 left_dot = appears(capture.dots->left, left), right_dot = appears(capture.dots->right, right);
    const dvec3 middle = closest_point({eye(x, false), left_dot, eye(x, true), right_dot}, C);
    put(held(capture.touch) - triple(x, layout_.offset) - middle);
    J.middleCols(after_arm, seen) = -C.middleCols<3>(3) * left - C.middleCols<3>(9) * right;
    J.middleCols<3>(after_arm + seen) = -C.leftCols<3>();
    J.middleCols<3>(after_arm + seen + 3) = -C.middleCols<3>(6);
    J.middleCols<3>(after_arm + seen + 6) = -Matrix3d::Identity();
  }

 private:
  Eigen::Matrix<double, 3, 8> by_panel(const VectorXd& x, const PanelPoint& mark) const {
    const dvec3 turn = triple(x, layout_.panel + 3);
    const dquat R = rotation_vector(turn);
    const dvec3 right = R * right_ * ((mark.u - 0.5) / width_), up = R * up_ * ((mark.v - 0.5) / height_);
    const dvec3 turned = right * (width_ + x[layout_.panel + 6]) + up * (height_ + x[layout_.panel + 7]);
    Eigen::Matrix<double, 3, 8> D;
    D << Matrix3d::Identity(), turn_derivative(turn, turned), eigen(right), eigen(up);
    return D;
  }
  /// Derivatives of the mirror's normal with respect to both tilts.
  std::array<dvec3, 2> by_tilt(const VectorXd& x) const {
    const dvec3 long_normal = bench_.rig.mirror->normal + x[layout_.mirror] * tilt_a_ + x[layout_.mirror + 1] * tilt_b_;
    const double length = glm::length(long_normal);
    const dvec3 n = long_normal / length;
    return {(tilt_a_ - n * glm::dot(n, tilt_a_)) / length, (tilt_b_ - n * glm::dot(n, tilt_b_)) / length};
  }

  struct Block {
    Kind kind;
    std::size_t index;
  };
  const BenchState& bench_;
  const Captures& captures_;
  Layout layout_;
  std::array<double, kArmParameters> arm0_{};
  std::map<int, std::pair<Eigen::Index, Pose>> place_;
  std::vector<Block> blocks_;
  dvec3 right_, up_, center_, tilt_a_{1, 0, 0}, tilt_b_{0, 0, 1}, pivot_{0, 0, 0};
  double width_ = 1, height_ = 1;
};

}  // namespace

JointResult solve_jointly(const BenchState& bench, const Captures& captures) {
  const auto started = std::chrono::steady_clock::now();
  const auto with_dots = std::count_if(captures.registration.begin(), captures.registration.end(),
                                       [](const PairCapture& c) { return c.dots.has_value(); });
  if (captures.marks.size() < 3 || captures.eyes.size() < 4 || with_dots < 4) {
    throw Error(
        "joint solution: found too few captures, expected panel marks, alignments of both eyes and touches with their "
        "dots");
  }
  const Model model(bench, captures);
  const Eigen::Index n = model.layout().size;
  const VectorXd scale = model.scale();
  const std::size_t blocks = model.blocks();
  std::vector<bool> used(blocks, true);
  std::vector<double> size(blocks);
  double sigma[kKinds];  // m, noise of a residual component for each kind of touch
  std::fill(sigma, sigma + kKinds, 2e-4);
  VectorXd x = VectorXd::Zero(n);
  Eigen::MatrixXd covariance;
  Columns slopes;
  JointResult result;
  for (int k = 0; k < kKinds; ++k) result.kinds.push_back({kKindNames[k], 0, 0, 0, 0});

  for (int round = 0; round < 60; ++round) {
    Eigen::MatrixXd JJ = Eigen::MatrixXd::Zero(n, n);
    VectorXd Jr = VectorXd::Zero(n);
    std::vector<double> lengths[kKinds];
    double squares[kKinds] = {};
    int counts[kKinds] = {};
    for (std::size_t b = 0; b < blocks; ++b) {
      const Kind kind = model.kind(b);
      const int rows = kSizes[kind];
      double r[3];
      const std::vector<Eigen::Index> unknowns = model.unknowns(b);
      slopes.resize(3, static_cast<Eigen::Index>(unknowns.size()));
      model.evaluate(x, b, r, slopes);
      double length2 = 0;
      for (int i = 0; i < rows; ++i) length2 += r[i] * r[i];
      size[b] = std::sqrt(length2);
      lengths[kind].push_back(size[b]);
      if (!used[b]) continue;
      squares[kind] += length2, counts[kind] += rows;
      Eigen::MatrixXd J = slopes.topRows(rows);
      for (std::size_t k = 0; k < unknowns.size(); ++k) J.col(static_cast<Eigen::Index>(k)) *= scale[unknowns[k]];
      const double weight = 1 / (sigma[kind] * sigma[kind]);
      const VectorXd gradient = J.transpose() * Eigen::Map<VectorXd>(r, rows);
      const Eigen::MatrixXd information = J.transpose() * J;
      for (std::size_t i = 0; i < unknowns.size(); ++i) {
        Jr[unknowns[i]] += weight * gradient[static_cast<Eigen::Index>(i)];
        for (std::size_t k = 0; k < unknowns.size(); ++k) {
          JJ(unknowns[i], unknowns[k]) +=
              weight * information(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k));
        }
      }
    }
    for (std::size_t k = 0; k < kKinds; ++k) {
      if (counts[k] > 0 && round == 0) result.kinds[k].before_rms = std::sqrt(squares[k] / counts[k]);
      if (counts[k] > 0) result.kinds[k].after_rms = std::sqrt(squares[k] / counts[k]);
    }
    // Prior: mean zero, plausible errors as standard deviations.
    const Eigen::MatrixXd information = JJ + Eigen::MatrixXd::Identity(n, n);
    const Eigen::LDLT<Eigen::MatrixXd> ldlt(information);
    const VectorXd step = -ldlt.solve(Jr + x.cwiseQuotient(scale));
    x += scale.cwiseProduct(step);
    covariance = ldlt.solve(Eigen::MatrixXd::Identity(n, n));

    // Noise of each kind of touch, from the median residual.
    if (round < 2 || step.norm() > 1e-3) continue;
    bool changed = false;
    for (std::size_t k = 0; k < kKinds; ++k) {
      if (lengths[k].empty()) continue;
      const double robust = sigma_of_lengths(lengths[k], kSizes[k]);
      // The noise is reduced gradually, because residuals of good touches are still large before convergence.
      const double next = std::clamp(robust, std::max(1e-7, 0.25 * sigma[k]), 5e-3);
      changed = changed || std::abs(std::log(next / sigma[k])) > 0.02;
      sigma[k] = next;
    }
    for (std::size_t b = 0; b < blocks; ++b) {
      const bool keep = size[b] <= 5 * sigma[model.kind(b)];
      changed = changed || keep != used[b];
      used[b] = keep;
    }
    if (!changed && step.norm() < 1e-6) break;
  }

  for (std::size_t b = 0; b < blocks; ++b) {
    ++result.kinds[static_cast<std::size_t>(model.kind(b))].touches;
    result.kinds[static_cast<std::size_t>(model.kind(b))].rejected += !used[b];
  }
  result.arm = model.arm(x);
  result.panel = model.panel(x);
  result.mirror = model.mirror(x);
  result.eyes = model.eyes(x);
  const Layout& at = model.layout();
  result.user_offset_W = triple(x, at.offset);
  const auto C = [&](Eigen::Index i, Eigen::Index j) { return covariance(i, j) * scale[i] * scale[j]; };
  for (int i = 0; i < 3; ++i) {
    result.user_offset_sigma[i] = std::sqrt(C(at.offset + i, at.offset + i));
    const Eigen::Index l = at.eyes + i, r = at.eyes + 3 + i;
    result.eye_center_sigma[i] = 0.5 * std::sqrt(std::max(0.0, C(l, l) + C(r, r) + 2 * C(l, r)));
  }
  double ipd = 0;
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < 6; ++j) {
      ipd += (i < 3 ? -1 : 1) * (j < 3 ? -1 : 1) * result.eyes.right[i % 3] * result.eyes.right[j % 3] *
             C(at.eyes + i, at.eyes + j);
    }
  }
  result.ipd_sigma = std::sqrt(std::max(0.0, ipd));
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - started).count();
  return result;
}

}  // namespace typodont::calibration
