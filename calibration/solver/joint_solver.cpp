#include "calibration/joint_solver.h"

#include <ceres/jet.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <numeric>

#include "calibration/solver/eigen_math.h"
#include "calibration/statistics.h"
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

constexpr Eigen::Index kBench = 23;  // unknowns of panel (11), mirror (6) and eyes (6)
using Jet = ceres::Jet<double, kBench>;
template <class T>
using Vec = sight::Vec<T>;
using sight::vec, sight::unit, sight::dot, sight::cross, sight::closest_point;

dquat rotation_vector(const dvec3& v) {
  return glm::normalize(dquat(1, 0.5 * v.x, 0.5 * v.y, 0.5 * v.z));
}
/// The vector p, turned by rotation_vector(v).
template <class T>
Vec<T> turned(const Vec<T>& v, const Vec<T>& p) {
  const Vec<T> g = T(0.5) * v, once = cross(g, p);
  return p + (T(2) / (T(1) + dot(g, g))) * (once + cross(g, once));
}
/// Derivative d(R p)/dv of a rotated vector, R = rotation_vector(v), `turned` = R p. With the Gibbs vector g = v/2: ω =
/// 2/(1+g²) (ġ + g × ġ) (Bauchau & Trainelli 2003, eq. 61).
Matrix3d turn_derivative(const dvec3& v, const dvec3& turned) {
  const dvec3 g = 0.5 * v;
  return -cross_matrix(turned) * (Matrix3d::Identity() + cross_matrix(g)) / (1 + glm::dot(g, g));
}

dvec3 triple(const VectorXd& x, Eigen::Index at) {
  return {x[at], x[at + 1], x[at + 2]};
}

constexpr auto kArmUnknowns = static_cast<Eigen::Index>(kArmParameters);

// Order of the unknowns, which are offsets from the first estimate, so that the prior has mean zero. Slips: by how much
// the tip sat elsewhere in its holder during the steps arm, screen and eyes.
struct Layout {
  Eigen::Index arm = 0, slips = kArmUnknowns, offset = slips + 9, bench = offset + 3, bow = bench + 8,
               mirror = bench + 11, sag = mirror + 3, eyes = bench + 17, size = bench + kBench;
};

/// A group of three unknowns that most benches do not need.
struct OptionalTerm {
  const char* name;
  Eigen::Index first;
  double scale;  // plausible size: m, or 1/m
};
constexpr Layout kLayout;
constexpr OptionalTerm kOptionalTerms[] = {{"panel bent", kLayout.bow, 5e-4},
                                           {kMirrorCurved, kLayout.sag, 0.05},
                                           {"tip slipped after step arm", kLayout.slips, 5e-4},
                                           {"tip slipped after step screen", kLayout.slips + 3, 5e-4},
                                           {"tip slipped after step eyes", kLayout.slips + 6, 5e-4}};

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
    if (bench.rig.mirror) {
      dvec3 sum(0);
      for (const Touch& t : captures.mirror) sum += bench.rig.X_WH * t.at(bench.arm);
      const dvec3 about = captures.mirror.empty() ? bench.rig.mirror->normal * bench.rig.mirror->offset
                                                  : sum / static_cast<double>(captures.mirror.size());
      start_ = sight::Mirror<double>::make(bench.rig.mirror->shape().normal, bench.rig.mirror->offset,
                                           vec<double>(about), {});
    }
  }

  const Layout& layout() const { return layout_; }
  std::size_t blocks() const { return blocks_.size(); }
  Kind kind(std::size_t block) const { return blocks_[block].kind; }

  VectorXd scale() const {
    VectorXd scale = VectorXd::Constant(layout_.size, 0.02);
    const auto arm = arm_parameter_scales();
    for (std::size_t i = 0; i < arm.size(); ++i) scale[static_cast<Eigen::Index>(i)] = arm[i];
    scale.segment<3>(layout_.bench + 3).setConstant(0.1);  // rad, plausible error of the panel's rotation
    scale.segment<2>(layout_.mirror).setConstant(0.1);     // rad, plausible error of the mirror's tilt
    for (const OptionalTerm& group : kOptionalTerms) scale.segment<3>(group.first).setConstant(group.scale);
    return scale;
  }

  ArmGeometry arm(const VectorXd& x) const {
    auto v = arm0_;
    for (std::size_t i = 0; i < v.size(); ++i) v[i] += x[layout_.arm + static_cast<Eigen::Index>(i)];
    return to_geometry(v);
  }
  Panel panel(const VectorXd& x) const {
    const sight::Panel<double> p = panel_of(x.data() + layout_.bench);
    const dvec3 corner = sight::plain(p.corner);
    return {corner, corner + sight::plain(p.right), corner + sight::plain(p.up), sight::plain(p.bow)};
  }
  std::optional<MirrorPlane> mirror(const VectorXd& x) const {
    if (!bench_.rig.mirror) return std::nullopt;
    const sight::Mirror<double> m = mirror_of(x.data() + layout_.bench);
    const dvec3 n = sight::plain(m.normal), middle = sight::plain(m.middle), curvature = sight::plain(m.curvature);
    return MirrorPlane{n, glm::dot(n, middle), curvature == dvec3(0) ? dvec3(0) : middle, curvature};
  }
  EyePair eyes(const VectorXd& x) const {
    const dvec3 l = sight::plain(eye_of(x.data() + layout_.bench, false)),
                r = sight::plain(eye_of(x.data() + layout_.bench, true));
    return {0.5 * (l + r), glm::length(r - l), glm::normalize(r - l)};
  }

  /// Residuals of a touch and their derivatives with respect to `unknowns`, the indices of the unknowns on which the
  /// touch depends.
  void evaluate(const VectorXd& x, std::size_t block, double* r, Columns& J,
                std::vector<Eigen::Index>& unknowns) const {
    const auto [kind, index] = blocks_[block];
    unknowns.clear();
    J.setZero(3, kArmUnknowns + 3 + 3 + std::max<Eigen::Index>(6, kBench));
    Eigen::Index used = 0;
    const auto depends = [&](Eigen::Index first, Eigen::Index count) {
      for (Eigen::Index i = 0; i < count; ++i) unknowns.push_back(first + i);
      used += count;
      return used - count;
    };
    const auto put = [&](const dvec3& e) { r[0] = e.x, r[1] = e.y, r[2] = e.z; };
    // The tip's position, and its derivatives.
    const auto held = [&](const ArmReading& reading, const dquat& R) {
      ArmGeometry geometry = arm(x);
      const Eigen::Index slip = layout_.slips + (kind == kArm ? 0 : kind == kEyes ? 6 : 3);
      if (kind != kTouch) geometry.tip_S += triple(x, slip);
      const auto slopes = tip_derivatives(geometry, reading);
      const Eigen::Index at = depends(layout_.arm, kArmUnknowns);
      for (Eigen::Index p = 0; p < kArmUnknowns; ++p) J.col(at + p) = eigen(R * slopes[static_cast<std::size_t>(p)]);
      if (kind != kTouch) J.middleCols<3>(depends(slip, 3)) = J.middleCols<3>(at + 12);  // as the tip's own place
      return tip_position(geometry, reading);
    };
    if (kind == kArm) {
      const auto& capture = captures_.arm[index];
      const auto& [at, X0] = place_.at(capture.group);
      const dvec3 tip = held(capture.reading, dquat(1, 0, 0, 0));
      dvec3 target = X0.p + triple(x, at);
      const Eigen::Index column = depends(at, capture.known ? 6 : 3);
      J.middleCols<3>(column) = -Matrix3d::Identity();
      if (capture.known) {
        const dvec3 turn = triple(x, at + 3), known = rotation_vector(turn) * X0.rotate(*capture.known);
        target += known;
        J.middleCols<3>(column + 3) = -turn_derivative(turn, known);
      }
      return put(tip - target);
    }
    const Touch& touch = kind == kPanel    ? captures_.marks[index].touch
                         : kind == kMirror ? captures_.mirror[index]
                         : kind == kEyes   ? captures_.eyes[index].touch
                                           : captures_.registration[index].touch;
    dvec3 p = touch.p_H;
    if (touch.reading && !captures_.arm.empty()) {
      p = held(*touch.reading, bench_.rig.X_WH.R);
    } else if (touch.reading) {
      p = tip_position(bench_.arm, *touch.reading);
    }
    p = bench_.rig.X_WH * p;
    std::array<Jet, kBench> y;
    for (int i = 0; i < kBench; ++i) y[static_cast<std::size_t>(i)] = Jet(x[layout_.bench + i], i);
    // The residuals are Σ across_i · (p − seen), or what depends on the bench alone: their derivatives by p, and by y.
    const auto residual = [&](Eigen::Index row, const Jet& value, const dvec3& by_p) {
      r[row] = value.a;
      J.row(row).head(used) = (eigen(by_p).transpose() * arm_part_).eval();
      bench_part_.row(row) = value.v.transpose();
    };
    arm_part_ = J.leftCols(used);
    const Vec<Jet> tip = vec<Jet>(p);
    if (kind == kPanel) {
      const PanelPoint& mark = captures_.marks[index].mark;
      const Vec<Jet> e = tip - panel_of(y.data()).at(Jet(mark.u), Jet(mark.v));
      residual(0, e.x, {1, 0, 0}), residual(1, e.y, {0, 1, 0}), residual(2, e.z, {0, 0, 1});
    } else if (kind == kMirror) {
      const sight::Mirror<double> plane = mirror_of(x.data() + layout_.bench);
      const Vec<double> d = vec<double>(p) - plane.middle;
      const auto [by_s, by_t] = plane.slope(dot(plane.a, d), dot(plane.b, d));
      residual(0, mirror_of(y.data()).height(tip), sight::plain(plane.normal - by_s * plane.a - by_t * plane.b));
    } else if (kind == kEyes) {
      const auto& capture = captures_.eyes[index];
      const Vec<Jet> from = eye_of(y.data(), capture.right), e = tip - from;
      const Vec<Jet> line = unit(appears(y.data(), capture.dot, from) - from);
      const Vec<Jet> across = unit(cross(line, vec<Jet>({0.36, 0.48, 0.8}))), other = cross(line, across);
      residual(0, dot(across, e), {across.x.a, across.y.a, across.z.a});
      residual(1, dot(other, e), {other.x.a, other.y.a, other.z.a});
    } else {
      const Dots& dots = *captures_.registration[index].dots;
      const Vec<Jet> left = eye_of(y.data(), false), right = eye_of(y.data(), true);
      const Vec<Jet> e =
          tip - vec<Jet>(triple(x, layout_.offset)) -
          closest_point(left, appears(y.data(), dots.left, left), right, appears(y.data(), dots.right, right));
      residual(0, e.x, {1, 0, 0}), residual(1, e.y, {0, 1, 0}), residual(2, e.z, {0, 0, 1});
      J.middleCols<3>(depends(layout_.offset, 3)) = -Matrix3d::Identity();
    }
    const int rows = kSizes[kind];
    J.topRows(rows).middleCols<kBench>(depends(layout_.bench, kBench)) = bench_part_.topRows(rows);
  }

 private:
  // Parts of the bench from its 23 unknowns.
  template <class T>
  sight::Panel<T> panel_of(const T* y) const {
    const Panel& p = bench_.rig.panel;
    const dvec3 right0 = p.lower_right - p.lower_left, up0 = p.upper_left - p.lower_left;
    const Vec<T> turn{y[3], y[4], y[5]};
    const Vec<T> right = (T(1) + y[6] / T(glm::length(right0))) * turned(turn, vec<T>(right0)),
                 up = (T(1) + y[7] / T(glm::length(up0))) * turned(turn, vec<T>(up0));
    const Vec<T> center = vec<T>(p.lower_left + 0.5 * (right0 + up0)) + Vec<T>{y[0], y[1], y[2]};
    return {center - T(0.5) * (right + up), right, up, {y[8], y[9], y[10]}};
  }
  template <class T>
  sight::Mirror<T> mirror_of(const T* y) const {
    const auto constant = [](const Vec<double>& v) { return vec<T>(sight::plain(v)); };
    const Vec<T> normal = unit(constant(start_.normal) + y[11] * constant(start_.a) + y[12] * constant(start_.b));
    const Vec<T> pivot = constant(start_.middle);
    return sight::Mirror<T>::make(normal, dot(normal, pivot) + y[13], pivot, {y[14], y[15], y[16]});
  }
  template <class T>
  Vec<T> eye_of(const T* y, bool right) const {
    const T* const moved = y + (right ? 20 : 17);
    return vec<T>(right ? bench_.rig.eyes.right_eye() : bench_.rig.eyes.left_eye()) +
           Vec<T>{moved[0], moved[1], moved[2]};
  }
  template <class T>
  Vec<T> appears(const T* y, const PanelPoint& dot, const Vec<T>& eye) const {
    const Vec<T> p = panel_of(y).at(T(dot.u), T(dot.v));
    return bench_.rig.mirror ? sight::seen_in(mirror_of(y), eye, p) : p;
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
  sight::Mirror<double> start_;  // the plane of the first estimate, about the middle of its touches
  // Memory of evaluate(): derivatives of the tip, and of the residuals by the bench.
  mutable Columns arm_part_;
  mutable Eigen::Matrix<double, 3, kBench> bench_part_;
};

}  // namespace

std::string size_in_words(const JointResult::Term& term) {
  const bool curvature = term.name == kMirrorCurved;
  const double unit = curvature ? 1 : 1e-3;
  return fmt::format("({:.3f}, {:.3f}, {:.3f}) ± ({:.3f}, {:.3f}, {:.3f}) {}", term.value.x / unit, term.value.y / unit,
                     term.value.z / unit, term.sigma.x / unit, term.sigma.y / unit, term.sigma.z / unit,
                     curvature ? "1/m" : "mm");
}

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
  VectorXd scale = model.scale();
  const std::size_t blocks = model.blocks();
  std::vector<bool> used(blocks, true);
  std::vector<double> size(blocks);
  double sigma[kKinds];  // m, noise of a residual component for each kind of touch
  std::fill(sigma, sigma + kKinds, 2e-4);
  VectorXd x = VectorXd::Zero(n);
  Eigen::MatrixXd covariance;  // of x / scale
  Columns slopes;
  std::vector<Eigen::Index> unknowns;
  JointResult result;
  for (int k = 0; k < kKinds; ++k) result.kinds.push_back({kKindNames[k], 0, 0, 0, 0});

  const auto fit = [&] {
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
        model.evaluate(x, b, r, slopes, unknowns);
        double length2 = 0;
        for (int i = 0; i < rows; ++i) length2 += r[i] * r[i];
        size[b] = std::sqrt(length2);
        lengths[kind].push_back(size[b]);
        if (!used[b]) continue;
        squares[kind] += length2, counts[kind] += rows;
        Eigen::MatrixXd J = slopes.topLeftCorner(rows, static_cast<Eigen::Index>(unknowns.size()));
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
        if (counts[k] > 0 && covariance.size() == 0) result.kinds[k].before_rms = std::sqrt(squares[k] / counts[k]);
        if (counts[k] > 0) result.kinds[k].after_rms = std::sqrt(squares[k] / counts[k]);
      }
      // Prior: mean zero, plausible errors as standard deviations.
      const Eigen::MatrixXd information = JJ + Eigen::MatrixXd::Identity(n, n);
      const Eigen::LDLT<Eigen::MatrixXd> ldlt(information);
      VectorXd left = Jr;
      for (Eigen::Index i = 0; i < n; ++i)
        if (scale[i] > 0) left[i] += x[i] / scale[i];
      const VectorXd step = -ldlt.solve(left);
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
  };

  // A term stays only if the touches show it: Wald's test, x C⁻¹ x against the chi-squared distribution. The weakest
  // term goes first, because terms explain the same touches in part. A term that is left out has the scale zero.
  const double evident = chi_squared_quantile(0.999, 3);
  std::vector<OptionalTerm> terms(std::begin(kOptionalTerms), std::end(kOptionalTerms));
  for (;;) {
    fit();
    result.terms.clear();
    double weakest = evident;
    std::size_t out = terms.size();
    for (std::size_t k = 0; k < terms.size(); ++k) {
      const Eigen::Index at = terms[k].first;
      const Vector3d found = x.segment<3>(at) / terms[k].scale;
      const Matrix3d C = covariance.block<3, 3>(at, at);
      const double evidence = found.dot(C.ldlt().solve(found));
      const Vector3d one_sigma = terms[k].scale * C.diagonal().cwiseSqrt();
      result.terms.push_back({terms[k].name, triple(x, at), {one_sigma[0], one_sigma[1], one_sigma[2]}, evidence});
      if (evidence < weakest) weakest = evidence, out = k;
    }
    if (out == terms.size()) break;
    x.segment<3>(terms[out].first).setZero();
    scale.segment<3>(terms[out].first).setZero();
    terms.erase(terms.begin() + static_cast<std::ptrdiff_t>(out));
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
