#include "calibration/joint_solver.h"

#include <Eigen/Dense>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <numeric>

#include "calibration/solver/least_squares.h"
#include "engine/base/error.h"

namespace typodont::calibration {

namespace {

using Eigen::VectorXd;

enum Kind { kArm, kPanel, kMirror, kEyes, kTouch, kKinds };
constexpr const char* kKindNames[kKinds] = {"arm", "panel", "mirror", "eyes", "touch"};
constexpr int kSizes[kKinds] = {3, 3, 1, 2, 3};

dquat rotation_vector(const dvec3& v) { return glm::normalize(dquat(1, 0.5 * v.x, 0.5 * v.y, 0.5 * v.z)); }
dvec3 triple(const VectorXd& x, Eigen::Index at) { return {x[at], x[at + 1], x[at + 2]}; }

// Where the unknowns lie in the vector. All are offsets from the start, so that zero is the prior's mean.
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
    // A frame for the panel and axes for the mirror.
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
      pivot_ = captures.mirror.empty() ? n * bench.rig.mirror->offset : sum / static_cast<double>(captures.mirror.size());
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
    scale.segment<3>(layout_.panel + 3).setConstant(0.1);  // rad
    scale.segment<2>(layout_.mirror).setConstant(0.1);     // rad
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
    const dvec3 right = R * right_ * (1 + x[layout_.panel + 6] / width_), up = R * up_ * (1 + x[layout_.panel + 7] / height_);
    const dvec3 corner = center - 0.5 * right - 0.5 * up;
    return {corner, corner + right, corner + up};
  }
  std::optional<MirrorPlane> mirror(const VectorXd& x) const {
    if (!bench_.rig.mirror) return std::nullopt;
    const dvec3 n = glm::normalize(bench_.rig.mirror->normal + x[layout_.mirror] * tilt_a_ + x[layout_.mirror + 1] * tilt_b_);
    return MirrorPlane{n, glm::dot(n, pivot_) + x[layout_.mirror + 2]};
  }
  dvec3 eye(const VectorXd& x, bool right) const {
    return (right ? bench_.rig.eyes.right_eye() : bench_.rig.eyes.left_eye()) + triple(x, layout_.eyes + (right ? 3 : 0));
  }
  EyePair eyes(const VectorXd& x) const {
    const dvec3 l = eye(x, false), r = eye(x, true);
    return {0.5 * (l + r), glm::length(r - l), glm::normalize(r - l)};
  }

  /// The unknowns a block depends on.
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

  void residual(const VectorXd& x, std::size_t block, double* r) const {
    const auto [kind, index] = blocks_[block];
    const ArmGeometry geometry = arm(x);
    const auto put = [&](const dvec3& e) { r[0] = e.x, r[1] = e.y, r[2] = e.z; };
    if (kind == kArm) {
      const auto& capture = captures_.arm[index];
      const auto& [at, X0] = place_.at(capture.group);
      dvec3 target = X0.p + triple(x, at);
      if (capture.known) target += rotation_vector(triple(x, at + 3)) * X0.rotate(*capture.known);
      put(tip_position(geometry, capture.reading) - target);
      return;
    }
    const auto held = [&](const Touch& touch) { return bench_.rig.X_WH * touch.at(geometry); };
    if (kind == kPanel) {
      const auto& capture = captures_.marks[index];
      put(held(capture.touch) - panel(x).at(capture.mark.u, capture.mark.v));
      return;
    }
    if (kind == kMirror) {
      const MirrorPlane plane = *mirror(x);
      r[0] = glm::dot(plane.normal, held(captures_.mirror[index])) - plane.offset;
      return;
    }
    const Panel screen = panel(x);
    const auto plane = mirror(x);
    const auto appears = [&](const PanelPoint& dot) {
      const dvec3 p = screen.at(dot.u, dot.v);
      return plane ? plane->reflect(p) : p;
    };
    if (kind == kEyes) {
      const auto& capture = captures_.eyes[index];
      const dvec3 from = eye(x, capture.right), sight = glm::normalize(appears(capture.dot) - from);
      const dvec3 across = glm::normalize(glm::cross(sight, dvec3(0.36, 0.48, 0.8))), e = held(capture.touch) - from;
      r[0] = glm::dot(across, e), r[1] = glm::dot(glm::cross(sight, across), e);
      return;
    }
    const auto& capture = captures_.registration[index];
    put(held(capture.touch) - triple(x, layout_.offset) -
        closest_point(eye(x, false), appears(capture.dots->left), eye(x, true), appears(capture.dots->right)));
  }

 private:
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
    throw Error("joint solution: found too few captures, expected panel marks, alignments of both eyes and touches with their dots");
  }
  const Model model(bench, captures);
  const Eigen::Index n = model.layout().size;
  const VectorXd scale = model.scale();
  const std::size_t blocks = model.blocks();
  std::vector<bool> used(blocks, true);
  std::vector<double> size(blocks);
  double sigma[kKinds];  // m per component
  std::fill(sigma, sigma + kKinds, 2e-4);
  VectorXd x = VectorXd::Zero(n);
  Eigen::MatrixXd covariance;
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
      double r[3], plus[3], minus[3];
      model.residual(x, b, r);
      double length2 = 0;
      for (int i = 0; i < rows; ++i) length2 += r[i] * r[i];
      size[b] = std::sqrt(length2);
      lengths[kind].push_back(size[b]);
      if (!used[b]) continue;
      squares[kind] += length2, counts[kind] += rows;
      const std::vector<Eigen::Index> unknowns = model.unknowns(b);
      Eigen::MatrixXd J(rows, static_cast<Eigen::Index>(unknowns.size()));
      VectorXd moved = x;
      for (std::size_t k = 0; k < unknowns.size(); ++k) {
        const Eigen::Index p = unknowns[k];
        const double h = 1e-3 * scale[p];
        moved[p] = x[p] + h, model.residual(moved, b, plus);
        moved[p] = x[p] - h, model.residual(moved, b, minus);
        moved[p] = x[p];
        for (int i = 0; i < rows; ++i) J(i, static_cast<Eigen::Index>(k)) = (plus[i] - minus[i]) * (scale[p] / (2 * h));
      }
      const double weight = 1 / (sigma[kind] * sigma[kind]);
      const VectorXd gradient = J.transpose() * Eigen::Map<VectorXd>(r, rows);
      const Eigen::MatrixXd information = J.transpose() * J;
      for (std::size_t i = 0; i < unknowns.size(); ++i) {
        Jr[unknowns[i]] += weight * gradient[static_cast<Eigen::Index>(i)];
        for (std::size_t k = 0; k < unknowns.size(); ++k) {
          JJ(unknowns[i], unknowns[k]) += weight * information(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k));
        }
      }
    }
    for (std::size_t k = 0; k < kKinds; ++k) {
      if (counts[k] > 0 && round == 0) result.kinds[k].before_rms = std::sqrt(squares[k] / counts[k]);
      if (counts[k] > 0) result.kinds[k].after_rms = std::sqrt(squares[k] / counts[k]);
    }
    // The prior (zero, one plausible error wide) keeps what no touch determines where it was.
    const Eigen::MatrixXd information = JJ + Eigen::MatrixXd::Identity(n, n);
    const Eigen::LDLT<Eigen::MatrixXd> ldlt(information);
    const VectorXd step = -ldlt.solve(Jr + x.cwiseQuotient(scale));
    x += scale.cwiseProduct(step);
    covariance = ldlt.solve(Eigen::MatrixXd::Identity(n, n));

    // Each kind of touch has its own noise; the median does not mind the slipped ones.
    if (round < 2 || step.norm() > 1e-3) continue;
    bool changed = false;
    for (std::size_t k = 0; k < kKinds; ++k) {
      if (lengths[k].empty()) continue;
      std::vector<double> sorted = lengths[k];
      std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2), sorted.end());
      const double robust = sorted[sorted.size() / 2] / (kSizes[k] == 1 ? 0.6745 : kSizes[k] == 2 ? 1.1774 : 1.5382);
      // Down by steps: what has not settled yet must not look like a slip.
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
      ipd += (i < 3 ? -1 : 1) * (j < 3 ? -1 : 1) * result.eyes.right[i % 3] * result.eyes.right[j % 3] * C(at.eyes + i, at.eyes + j);
    }
  }
  result.ipd_sigma = std::sqrt(std::max(0.0, ipd));
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - started).count();
  return result;
}

}  // namespace typodont::calibration
