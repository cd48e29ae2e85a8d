#include "haptics/import/jaw.h"

#include <array>
#include <cmath>
#include <numeric>

#include "engine/base/quantile.h"
#include "engine/base/units.h"
#include "engine/base/voxels.h"

namespace typodont::haptics::importing {

namespace {

double cubed(double x) {
  return x * x * x;
}

// Returns the connected components that have at least `samples` samples.
SparseMask large_parts(const SparseMask& mask, double samples) {
  const SparseComponents parts = components(mask);
  SparseMask large(mask.set, 0, 0);
  for_each_sample(*mask.set, [&](std::size_t i) {
    const auto id = static_cast<std::size_t>(parts.label.v[i]);
    large.v[i] = id > 0 && static_cast<double>(parts.voxels[id]) >= samples;
  });
  return large;
}

// Random walker (Grady 2006, "Random walks for image segmentation"): probability that a walk from a sample reaches a
// crown before bone. Steps to dim samples are unlikely, so the periodontal ligament separates tooth and bone. Solved by
// conjugate gradients down to `residual`. Samples in `bone` absorb the walk; elsewhere it goes to bone with weight
// `into_bone`.
Sparse<float> tooth_probability(const Sparse<float>& grey, const SparseMask& bright, const SparseMask& crown,
                                const SparseMask& bone, const Sparse<float>& into_bone, const JawGreys& greys,
                                double residual, const std::function<void(double)>& progress) {
  const BlockSet& set = *grey.set;
  std::vector<std::size_t> sample_of;  // for each unknown of the equations: index of its sample
  Sparse<std::int32_t> unknown(grey.set, -1, -1);
  for (std::size_t i = 0; i < bright.v.size(); ++i) {
    if (!bright.v[i] || crown.v[i] || bone.v[i] || !set.holds(set.place(i))) continue;
    unknown.v[i] = static_cast<std::int32_t>(sample_of.size());
    sample_of.push_back(i);
  }
  struct Row {
    std::array<std::int32_t, 6> to;
    std::array<float, 6> weight;
  };
  const std::size_t n = sample_of.size();
  std::vector<Row> rows(n);
  std::vector<double> diagonal(n), b(n), x(n, 0.0);
  // Smallest weight of a step. It applies if the darker of its two samples is at the threshold of bright samples.
  constexpr double kMin = 1e-4;
  for_each_in_parallel(n, [&](std::size_t k) {
    const std::size_t i = sample_of[k];
    const glm::ivec3 p = set.place(i);
    double sum = std::max(1e-9, static_cast<double>(into_bone.v[i])), known = 0;
    for (std::size_t f = 0; f < 6; ++f) {
      rows[k].to[f] = -1, rows[k].weight[f] = 0;
      const glm::ivec3 q = p + kFaceSteps[f];
      if (!set.holds(q)) continue;
      const std::ptrdiff_t j = grey.index(q);
      if (j < 0 || !bright.v[static_cast<std::size_t>(j)]) continue;
      const auto other = static_cast<std::size_t>(j);
      const double least = static_cast<double>(std::min(grey.v[i], grey.v[other]));
      const double fraction = std::clamp((least - greys.bright()) / (greys.hard - greys.bright()), 0.0, 1.0);
      const double weight = kMin + fraction * fraction * fraction * fraction;
      sum += weight;
      if (crown.v[other]) known += weight;
      rows[k].to[f] = unknown.v[other];
      rows[k].weight[f] = static_cast<float>(weight);
    }
    diagonal[k] = sum;
    b[k] = known;
  });
  // Sums part(from, to) over ranges of fixed size, so that the result does not depend on the number of cores.
  constexpr std::size_t kRange = 16384;
  std::vector<double> sums((n + kRange - 1) / kRange);
  const auto sum_of = [&](auto part) {
    for_each_in_parallel(sums.size(),
                         [&](std::size_t k) { sums[k] = part(k * kRange, std::min((k + 1) * kRange, n)); });
    return std::accumulate(sums.begin(), sums.end(), 0.0);
  };
  std::vector<double> r = b, d(n), ad(n);
  double rz = sum_of([&](std::size_t from, std::size_t to) {
    double sum = 0;
    for (std::size_t k = from; k < to; ++k) d[k] = r[k] / diagonal[k], sum += r[k] * d[k];
    return sum;
  });
  const double enough = residual * rz;
  constexpr int kMaxSteps = 2000;
  for (int step = 0; step < kMaxSteps && rz > enough; ++step) {
    constexpr int kToldEvery = 16, kUsualSteps = 400;
    if (step % kToldEvery == 0) progress(std::min(1.0, static_cast<double>(step) / kUsualSteps));
    const double d_a_d = sum_of([&](std::size_t from, std::size_t to) {
      double all = 0;
      for (std::size_t k = from; k < to; ++k) {
        double sum = diagonal[k] * d[k];
        for (std::size_t f = 0; f < 6; ++f) {
          if (rows[k].to[f] >= 0)
            sum -= static_cast<double>(rows[k].weight[f]) * d[static_cast<std::size_t>(rows[k].to[f])];
        }
        ad[k] = sum;
        all += d[k] * sum;
      }
      return all;
    });
    const double alpha = rz / d_a_d;
    const double next = sum_of([&](std::size_t from, std::size_t to) {
      double sum = 0;
      for (std::size_t k = from; k < to; ++k) {
        x[k] += alpha * d[k], r[k] -= alpha * ad[k];
        sum += r[k] * r[k] / diagonal[k];
      }
      return sum;
    });
    const double turn = next / rz;
    for_each_in_parallel(sums.size(), [&](std::size_t range) {
      for (std::size_t k = range * kRange; k < std::min((range + 1) * kRange, n); ++k)
        d[k] = r[k] / diagonal[k] + turn * d[k];
    });
    rz = next;
  }
  Sparse<float> probability(grey.set, 0, 0);
  for (std::size_t i = 0; i < crown.v.size(); ++i) probability.v[i] = crown.v[i] ? 1 : 0;
  for (std::size_t k = 0; k < n; ++k) probability.v[sample_of[k]] = static_cast<float>(std::clamp(x[k], 0.0, 1.0));
  return probability;
}

// Eigenvalues in ascending order (Smith 1961).
glm::dvec3 eigenvalues(const glm::dmat3& a) {
  const double off = a[0][1] * a[0][1] + a[0][2] * a[0][2] + a[1][2] * a[1][2];
  const double mean = (a[0][0] + a[1][1] + a[2][2]) / 3;
  const glm::dvec3 d = glm::dvec3(a[0][0], a[1][1], a[2][2]) - mean;
  const double p = std::sqrt((glm::dot(d, d) + 2 * off) / 6);
  if (!(p > 1e-12)) return glm::dvec3(mean);
  const double half = std::clamp(0.5 * glm::determinant((a - glm::dmat3(mean)) / p), -1.0, 1.0);
  const double angle = std::acos(half) / 3;
  const double most = mean + 2 * p * std::cos(angle), least = mean + 2 * p * std::cos(angle + 2 * kPi / 3);
  return {least, 3 * mean - most - least, most};
}

// Second derivatives at a sample; zero at the border of the volume.
glm::dmat3 second_derivatives(const Sparse<float>& g, const glm::ivec3& p) {
  glm::dmat3 h(0);
  if (glm::any(glm::lessThan(p, glm::ivec3(1))) || glm::any(glm::greaterThan(p + 2, g.set->size))) return h;
  const auto at = [&](int x, int y, int z) { return static_cast<double>(g[p + glm::ivec3(x, y, z)]); };
  const double middle = at(0, 0, 0);
  h[0][0] = at(1, 0, 0) + at(-1, 0, 0) - 2 * middle;
  h[1][1] = at(0, 1, 0) + at(0, -1, 0) - 2 * middle;
  h[2][2] = at(0, 0, 1) + at(0, 0, -1) - 2 * middle;
  h[0][1] = h[1][0] = 0.25 * (at(1, 1, 0) + at(-1, -1, 0) - at(1, -1, 0) - at(-1, 1, 0));
  h[0][2] = h[2][0] = 0.25 * (at(1, 0, 1) + at(-1, 0, -1) - at(1, 0, -1) - at(-1, 0, 1));
  h[1][2] = h[2][1] = 0.25 * (at(0, 1, 1) + at(0, -1, -1) - at(0, 1, -1) - at(0, -1, 1));
  return h;
}

// Returns Segmentation::grey, but in dark valleys (gaps between roots and sockets) with the grey value of the scan.
Sparse<float> with_valleys(const Grid<float>& scan, const Segmentation& s, const JawGreys& greys) {
  constexpr double kSmooth = 0.8;  // voxels, standard deviation of the smoothing
  // Smallest curvature of a valley, per voxel², as a fraction of the contrast between hard and soft tissue. A ligament
  // that is one voxel wide has three times this curvature.
  constexpr double kValley = 0.1;
  const std::shared_ptr<const BlockSet>& set = s.grey.set;
  const Sparse<float> smooth = gaussian(scan, set, kSmooth, s.grey.outside, s.grey.inside);
  Sparse<float> grey = s.grey;
  for_each_sample(*set, [&](const glm::ivec3& p, std::size_t i) {
    if (!(s.surface.distance[p] < 0)) return;
    if (eigenvalues(second_derivatives(smooth, p)).z > kValley * (greys.hard - greys.soft))
      grey.v[i] = std::min(grey.v[i], scan[p]);
  });
  return grey;
}

// Grey value at the borders of a thin dark layer of width w, from its darkest value. Decrease of the grey value as a
// fraction of the true contrast: erf(w / (2√2 σ)) in the middle, erf(w / (√2 σ)) / 2 at the borders. σ: blur.
class LayerBound {
 public:
  LayerBound() {
    std::size_t next = 0;
    for (double ratio = 0; next < sunk_.size(); ratio += 1e-3) {
      while (next < sunk_.size() && (std::erf(ratio) >= static_cast<double>(next) / kSteps || ratio > 3))
        sunk_[next++] = 0.5 * std::erf(2 * ratio);
    }
  }
  double operator()(double dip) const { return sunk_[static_cast<std::size_t>(std::clamp(dip, 0.0, 1.0) * kSteps)]; }

 private:
  static constexpr int kSteps = 200;
  std::array<double, kSteps + 1> sunk_{};
};

// Grey value at a canal's border, on a scale: 0 in the canal, 1 in a thick wall, `beyond` in bone. Blur dims a thin
// wall: so the thickness follows from the brightest value across the wall, and the border's value from the thickness.
class CanalBound {
 public:
  /// `blur`, `sigma`, `radius` (of the canal): voxels. The grey values must be smoothed by smooth_in_place(g, sigma,
  /// blur), which corrects the effect of curvature only where grey values vary slowly.
  CanalBound(double blur, double sigma, double beyond, double radius) {
    constexpr double kStep = 0.1, kThickest = 6;  // voxels; step and end of the table of wall thicknesses
    // Smallest rise from bone (0) to wall (1); a smaller rise is normal variation of bone.
    constexpr double kWall = 0.2;
    least_ = glm::mix(beyond, 1.0, kWall);
    const double c = sharpening(sigma, blur), once = std::hypot(blur, sigma), twice = std::hypot(once, sigma);
    const auto step_at = [](double x, double width) { return 0.5 * std::erfc(-x / (std::sqrt(2.0) * width)); };
    const auto curved = [](double x, double width) {
      return width / std::sqrt(2 * kPi) * std::exp(-0.5 * x * x / (width * width));
    };
    // Grey value at x (voxels) of a cylindrical edge at x = 0 (step from 0 to 1), after blur and smoothing.
    const auto edge = [&](double x, double curvature) {
      return (1 + c) * (step_at(x, once) + 0.5 * curvature * curved(x, once)) -
             c * (step_at(x, twice) + 0.5 * curvature * curved(x, twice));
    };
    for (double thickness = 0; thickness <= kThickest; thickness += kStep) {
      const auto across = [&](double x) {
        return edge(x, 1 / radius) - (1 - beyond) * edge(x - thickness, 1 / (radius + thickness));
      };
      double most = beyond;
      for (double x = 0; x <= thickness; x += kStep) most = std::max(most, across(x));
      brightest_.push_back(std::max(most, brightest_.empty() ? 0 : brightest_.back()));
      border_.push_back(across(0));
    }
  }
  double operator()(double brightest) const {
    if (brightest < least_) return border_[0];
    const auto k = static_cast<std::size_t>(std::ranges::lower_bound(brightest_, brightest) - brightest_.begin());
    if (k == 0) return border_[0];
    if (k == border_.size()) return border_.back();
    const double rise = brightest_[k] - brightest_[k - 1];
    return glm::mix(border_[k - 1], border_[k], rise > 0 ? (brightest - brightest_[k - 1]) / rise : 1);
  }

 private:
  double least_;  // if the brightest value is below this, the canal has no wall
  // For each thickness of the wall, in ascending order: brightest value across the wall; value at the canal's border.
  std::vector<double> brightest_, border_;
};

// Median of value(i) over the samples i for which test(i) is true; nullopt if there are fewer than kMin samples.
// `count` receives their number.
template <class Test, class Value>
std::optional<double> median_of(const SparseMask& samples, Test test, Value value, std::size_t* count = nullptr) {
  constexpr std::size_t kMin = 20;  // with fewer values, there is no median
  std::vector<float> values;
  for (std::size_t i = 0; i < samples.v.size(); ++i) {
    if (samples.v[i] && test(i)) values.push_back(value(i));
  }
  if (count) *count = values.size();
  if (values.size() < kMin) return std::nullopt;
  return nth(values, values.size() / 2);
}

// Median grey value of a tissue's samples that are at least about 2.5 times `blur` deep (voxels).
std::optional<double> grey_inside(const Grid<float>& scan, const SparseMask& tissue, double blur) {
  const std::shared_ptr<const BlockSet>& set = tissue.set;
  const SparseMask around = where(set, true, false, [&](std::size_t i) { return !tissue.v[i]; });
  const Sparse<float> into = distance_squared_to(around, 4);
  for (const double squared : {12.0, 9.0, 6.0, 4.0}) {  // voxels², depths of 3.5, 3, 2.45 and 2 voxels
    // Uses only samples at least min(kBlurs × `blur` + 0.5, kBlurs) voxels deep, from the next sample outside.
    constexpr double kBlurs = 2.4;
    if (std::sqrt(squared) < std::min(kBlurs * blur + 0.5, kBlurs)) break;
    const std::optional<double> grey = median_of(
        tissue, [&](std::size_t i) { return into.v[i] >= static_cast<float>(squared); },
        [&](std::size_t i) { return scan[set->place(i)]; });
    if (grey) return grey;
  }
  return std::nullopt;
}

// Finds nerve canals: dark tubes of about 2.5 mm diameter (after Frangi 1998), which vary strongly across and little
// along their axis.
void find_canals(const Sparse<float>& grey, const SparseMask& bone, const JawGreys& greys, double voxel,
                 SparseMask& canal, std::vector<JawCanal>& found) {
  // Radius of a canal, length of the shortest canal, distance between points of its centre line; m.
  constexpr double kRadius = 1.25e-3, kMinLength = 8e-3, kEvery = 0.5e-3;
  // Smallest tube measure of a canal: scaled second derivative across the canal, divided by the difference of grey
  // values of bone and canal. A canal of radius kRadius has about 1/3.
  constexpr double kMinTube = 0.15;
  const double sigma = 0.6 * kRadius / voxel;
  Sparse<float> field(grey.set, static_cast<float>(greys.cancellous), static_cast<float>(greys.cancellous));
  for_each_sample(*grey.set, [&](std::size_t i) {
    if (bone.v[i])
      field.v[i] = std::clamp(grey.v[i], static_cast<float>(greys.soft), static_cast<float>(greys.cancellous));
  });
  field = gaussian(field, sigma);
  const double contrast = greys.cancellous - greys.soft;
  Sparse<float> tube(grey.set, 0, 0);
  for_each_sample(*grey.set, [&](const glm::ivec3& p, std::size_t i) {
    if (!bone.v[i]) return;
    const glm::dvec3 e = eigenvalues(second_derivatives(field, p) * (sigma * sigma / contrast));
    if (e.y > 0) tube.v[i] = static_cast<float>(std::sqrt(e.y * e.z) - std::abs(e.x));
  });
  const SparseMask likely =
      where(grey.set, false, false, [&](std::size_t i) { return tube.v[i] > static_cast<float>(kMinTube); });
  const SparseComponents parts = components(likely, true);
  for (std::size_t id = 1; id < parts.voxels.size(); ++id) {
    if (static_cast<double>(parts.voxels[id]) * voxel < kMinLength) continue;
    std::vector<std::size_t> samples;
    glm::dvec3 mean(0);
    for (std::size_t i = 0; i < likely.v.size(); ++i) {
      if (parts.label.v[i] == static_cast<std::int32_t>(id)) samples.push_back(i), mean += glm::dvec3(likely.place(i));
    }
    mean /= static_cast<double>(samples.size());
    // Direction in which the samples extend farthest, by power iteration.
    glm::dmat3 spread(0);
    for (const std::size_t i : samples) {
      const glm::dvec3 r = glm::dvec3(likely.place(i)) - mean;
      spread += glm::outerProduct(r, r);
    }
    glm::dvec3 axis(1, 0.7, 0.4);
    for (int k = 0; k < 60; ++k) axis = glm::normalize(spread * axis);
    double lo = 1e300, hi = -1e300;
    for (const std::size_t i : samples) {
      const double t = glm::dot(glm::dvec3(likely.place(i)) - mean, axis);
      lo = std::min(lo, t), hi = std::max(hi, t);
    }
    if ((hi - lo) * voxel < kMinLength) continue;
    // Slices across the canal; each gives a point of the centre line, weighted by the tube measure.
    const double every = kEvery / voxel;
    const auto slices = static_cast<std::size_t>((hi - lo) / every) + 1;
    std::vector<glm::dvec3> centre(slices, glm::dvec3(0));
    std::vector<double> weight(slices, 0);
    for (const std::size_t i : samples) {
      const glm::dvec3 q(likely.place(i));
      const auto k = static_cast<std::size_t>((glm::dot(q - mean, axis) - lo) / every);
      const auto w = static_cast<double>(tube.v[i]);
      centre[k] += w * q, weight[k] += w;
    }
    JawCanal line;
    for (std::size_t k = 0; k < slices; ++k) {
      if (weight[k] > 0) line.centre.push_back(centre[k] / weight[k]);
    }
    double rough = 0;
    for (std::size_t k = 1; k + 1 < line.centre.size(); ++k) {
      const glm::dvec3 bend = line.centre[k] - 0.5 * (line.centre[k - 1] + line.centre[k + 1]);
      rough += glm::dot(bend, bend) / 1.5;
    }
    line.uncertainty = voxel * std::sqrt(rough / static_cast<double>(std::max<std::size_t>(line.centre.size(), 3) - 2));
    found.push_back(std::move(line));
    for (const std::size_t i : samples) canal.v[i] = 1;
  }
}

// Corrects root canals, which blur narrows. Blur does not change the sum of (dentin − grey) over a canal, so the
// canal's volume is this sum / (dentin − pulp). A sample near the border is pulp if a ball around it contains fewer
// darker samples than this volume. `to_crown`: squared distance; `blur`: voxels; `soft_elsewhere`: grey value for pulps
// that are too narrow to measure; `brightest_soft`: replaces the grey value of a pulp that is much brighter.
void correct_canals(const Grid<float>& scan, const Sparse<float>& smooth, const SparseMask& tooth,
                    const Sparse<float>& to_crown, const JawGreys& greys, double blur, double soft_elsewhere,
                    double brightest_soft, Sparse<Tissue>& tissue) {
  // kBlurred: up to this distance from a border, blur changes samples. kBall: radius of a ball around a canal. Voxels.
  constexpr float kBlurred = 2.5;
  constexpr int kBall = 6;
  // Fewest dentin samples from which the grey value of dentin is taken: near a sample (kMin), in all teeth (kEnough).
  constexpr std::size_t kMin = 20, kEnough = 200;
  // kBrightest, kDarkest: limits of a sample's pulp fraction; below 0 and above 1, because of noise and enamel.
  constexpr double kBrightest = -0.25;
  constexpr double kDarkest = 1.25;
  const std::shared_ptr<const BlockSet>& set = tissue.set;
  const SparseMask pulp =
      where(set, false, false, [&](std::size_t i) { return tooth.v[i] && tissue.v[i] == Tissue::kPulp; });
  const SparseMask others = where(set, true, false, [&](std::size_t i) {
    return !tooth.v[i] ||
           (tissue.v[i] != Tissue::kPulp && tissue.v[i] != Tissue::kDentin && tissue.v[i] != Tissue::kEnamel);
  });
  const SparseMask no_pulp = where(set, true, false, [&](std::size_t i) { return !pulp.v[i]; });
  const Sparse<float> to_pulp = distance_squared_to(pulp, kBall), to_other = distance_squared_to(others, 4),
                      into_pulp = distance_squared_to(no_pulp, 4);
  // Voxels. Dentin is measured at least kUnblurred deep, where blur does not change it; in thin roots, down to kMinFar.
  // greys.hard cannot be used, because it comes mostly from bone.
  constexpr double kUnblurred = 3, kMinFar = 1.5;
  SparseMask core_mask;
  std::optional<double> dentin_grey;
  for (double far = kUnblurred; far >= kMinFar; far -= 0.5) {
    const auto squared = static_cast<float>(far * far);
    core_mask = where(set, false, false, [&](std::size_t i) {
      return tooth.v[i] && tissue.v[i] == Tissue::kDentin && to_pulp.v[i] >= squared && to_other.v[i] >= squared &&
             to_crown.v[i] >= squared;
    });
    std::size_t count = 0;
    dentin_grey = median_of(
        core_mask, [](std::size_t) { return true; }, [&](std::size_t i) { return scan[set->place(i)]; }, &count);
    if (count >= kEnough) break;
  }
  const auto is_core = [&](std::size_t i) { return core_mask.v[i] != 0; };
  const double dentin = dentin_grey.value_or(greys.hard), own = grey_inside(scan, pulp, blur).value_or(soft_elsewhere);
  // Pulp that is brighter than `brightest_soft` by more than this counts as brightened by streaks of metal.
  constexpr double kStreaks = 0.05;  // fraction of the contrast between dentin and soft tissue (no streaks: below 0.02)
  const double soft = own > brightest_soft + kStreaks * (dentin - brightest_soft) ? brightest_soft : own;
  const auto near_canal = [&](std::size_t i) {
    return tooth.v[i] && (tissue.v[i] == Tissue::kPulp || tissue.v[i] == Tissue::kDentin) &&
           to_pulp.v[i] <= kBlurred * kBlurred && to_pulp.v[i] < to_other.v[i];
  };
  Sparse<Tissue> corrected = tissue;
  for_each_sample(*set, [&](const glm::ivec3& p, std::size_t i) {
    // Only samples near a canal's border may change; samples deeper in the pulp or farther from it keep their labels.
    if (!near_canal(i) || into_pulp.v[i] > kBlurred * kBlurred) return;
    double core = 0, samples = 0, darker = 0;
    const auto pulp_fraction = [&](double grey, double bright) {
      return std::clamp((bright - grey) / (bright - soft), kBrightest, kDarkest);
    };
    const auto around = [&](auto work) {
      for_each_voxel_between(glm::ivec3(-kBall), glm::ivec3(kBall), [&](int x, int y, int z) {
        const glm::ivec3 q = p + glm::ivec3(x, y, z);
        if (x * x + y * y + z * z > kBall * kBall || !set->holds(q)) return;
        if (const std::ptrdiff_t j = tissue.index(q); j >= 0) work(static_cast<std::size_t>(j), q);
      });
    };
    around([&](std::size_t j, const glm::ivec3& q) {
      if (is_core(j)) core += static_cast<double>(scan[q]), samples += 1;
    });
    const double bright = samples >= static_cast<double>(kMin) ? core / samples : dentin;
    double volume = 0;
    around([&](std::size_t j, const glm::ivec3& q) {
      if (!near_canal(j)) return;
      volume += pulp_fraction(static_cast<double>(scan[q]), bright);
      darker += smooth.v[j] < smooth.v[i];
    });
    corrected.v[i] = darker + 0.5 < volume ? Tissue::kPulp : Tissue::kDentin;
  });
  tissue = std::move(corrected);
}

// Finds single teeth: regions grow from maxima of depth (distance from the mask's surface). Two regions are one tooth,
// unless they meet at a depth much smaller than that of each. Only regions with `crown` count. Results in samples.
std::vector<JawTooth> find_teeth(const SparseMask& teeth, const SparseMask& crown, double voxel, double least) {
  // Larger depths count as kDeepest, m. kContact: largest depth of a contact between two teeth, as a fraction of the
  // shallower tooth's depth.
  constexpr double kDeepest = 4e-3, kContact = 0.75;
  const std::shared_ptr<const BlockSet>& set = teeth.set;
  const SparseMask others = where(set, true, false, [&](std::size_t i) { return !teeth.v[i]; });
  const int reach = static_cast<int>(std::clamp(kDeepest / voxel, 4.0, 32.0));
  const Sparse<float> depth = distance_squared_to(others, reach);
  const auto limited = [&](std::size_t i) { return std::min(depth.v[i], static_cast<float>(reach * reach)); };
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < teeth.v.size(); ++i) {
    if (teeth.v[i] && set->holds(set->place(i))) order.push_back(i);
  }
  std::ranges::stable_sort(order, [&](std::size_t a, std::size_t b) { return limited(a) > limited(b); });
  struct Part {
    std::int32_t joined_to;
    float top;  // squared depth of the region's deepest sample
    double samples = 0, bright = 0;
    dvec3 sum{0};
  };
  std::vector<Part> parts;
  Sparse<std::int32_t> part_of(set, -1, -1);
  const auto root = [&](std::int32_t part) {
    while (parts[static_cast<std::size_t>(part)].joined_to != part)
      part = parts[static_cast<std::size_t>(part)].joined_to;
    return part;
  };
  for (const std::size_t i : order) {
    const glm::ivec3 p = set->place(i);
    std::int32_t mine = -1;
    for (const glm::ivec3& face : kFaceSteps) {
      const glm::ivec3 q = p + face;
      if (!set->holds(q) || part_of[q] < 0) continue;
      const std::int32_t other = root(part_of[q]);
      if (mine < 0 || mine == other) {
        mine = other;
        continue;
      }
      Part &a = parts[static_cast<std::size_t>(mine)], &b = parts[static_cast<std::size_t>(other)];
      if (limited(i) < static_cast<float>(kContact * kContact) * std::min(a.top, b.top)) {
        if (b.top > a.top) mine = other;
        continue;
      }
      Part& deeper = a.top >= b.top ? a : b;
      Part& shallower = a.top >= b.top ? b : a;
      deeper.samples += shallower.samples, deeper.bright += shallower.bright, deeper.sum += shallower.sum;
      shallower.joined_to = deeper.joined_to;
      mine = deeper.joined_to;
    }
    if (mine < 0) {
      mine = static_cast<std::int32_t>(parts.size());
      parts.push_back({mine, limited(i)});
    }
    part_of.v[i] = mine;
    Part& part = parts[static_cast<std::size_t>(mine)];
    part.samples += 1, part.bright += crown.v[i], part.sum += dvec3(p);
  }
  std::vector<JawTooth> found;
  for (std::size_t k = 0; k < parts.size(); ++k) {
    const Part& part = parts[k];
    if (part.joined_to == static_cast<std::int32_t>(k) && part.bright >= least)
      found.push_back({part.sum / part.samples, part.samples});
  }
  std::ranges::sort(found, std::greater<>(), &JawTooth::volume);
  return found;
}

}  // namespace

JawGreys find_jaw_greys(const Grid<float>& smoothed, double surface, double offset, double noise) {
  constexpr int kBins = 300;
  // Grey value of the brightest enamel, Hounsfield units.
  constexpr double kBrightest = 3600;
  const double lo = surface, width = (offset + kBrightest - lo) / kBins, steepest = std::max(120.0, 3 * noise);
  std::array<double, kBins> count{};
  for_each_voxel_between(glm::ivec3(1), smoothed.size - 2, [&](int x, int y, int z) {
    const auto g = static_cast<double>(smoothed(x, y, z));
    if (!(g >= lo) || !(g < lo + kBins * width)) return;
    const glm::dvec3 slope(smoothed(x + 1, y, z) - smoothed(x - 1, y, z), smoothed(x, y + 1, z) - smoothed(x, y - 1, z),
                           smoothed(x, y, z + 1) - smoothed(x, y, z - 1));
    if (glm::length(slope) < 2 * steepest) count[static_cast<std::size_t>((g - lo) / width)] += 1;
  });
  // Thresholds between three classes of grey values, with the smallest variance within classes (Otsu 1979).
  std::array<double, kBins + 1> mass{}, moment{};
  for (std::size_t i = 0; i < kBins; ++i) {
    mass[i + 1] = mass[i] + count[i];
    moment[i + 1] = moment[i] + count[i] * (static_cast<double>(i) + 0.5);
  }
  const auto between = [&](std::size_t from, std::size_t to) {
    const double m = mass[to] - mass[from], s = moment[to] - moment[from];
    return m > 0 ? s * s / m : 0;
  };
  std::size_t first = 1, second = 2;
  double best = -1;
  for (std::size_t a = 1; a < kBins; ++a) {
    for (std::size_t b = a + 1; b < kBins; ++b) {
      const double variance = between(0, a) + between(a, b) + between(b, kBins);
      if (variance > best) best = variance, first = a, second = b;
    }
  }
  // Most frequent grey value of a class, given as a range of the histogram's bins.
  const auto mode = [&](std::size_t from, std::size_t to) {
    // Bins on each side that are counted together with a bin.
    constexpr std::size_t kHalf = 6;
    double most = -1, at = 0;
    for (std::size_t i = from; i < to; ++i) {
      const double near = mass[std::min(i + kHalf + 1, to)] - mass[i > from + kHalf ? i - kHalf : from];
      if (near > most) most = near, at = static_cast<double>(i) + 0.5;
    }
    return lo + width * at;
  };
  JawGreys greys;
  greys.soft = offset;
  greys.cancellous = mode(0, first);
  greys.hard = mode(first, second);
  greys.enamel = mode(second, kBins);
  // Density of enamel divided by that of dentin and cortical bone.
  constexpr double kDenser = 1.3;
  // If the brightest class contains other tissue besides enamel, this class is divided again.
  constexpr double kMinEnamel = 0.003;  // smallest number of enamel voxels, as a fraction of the bright voxels
  const auto crown = static_cast<std::size_t>(std::clamp((greys.crown() - lo) / width, 0.0, kBins - 1.0));
  std::size_t third = crown + 1;
  for (std::size_t c = crown + 1; c < kBins; ++c) {
    if (between(crown, c) + between(c, kBins) > between(crown, third) + between(third, kBins)) third = c;
  }
  const double upper = mode(third, kBins);
  if (upper - offset > kDenser * (greys.enamel - offset) && mass[kBins] - mass[third] > kMinEnamel * mass[kBins]) {
    greys.hard = mode(crown, third);
    greys.enamel = upper;
  }
  // The contrast from enamel to metal is larger than that from dentin to enamel.
  const double min_metal = 2 * greys.enamel - greys.hard;
  std::vector<float> metal;
  for (const float g : smoothed.v) {
    if (static_cast<double>(g) > min_metal) metal.push_back(g);
  }
  constexpr std::size_t kMinMetal = 40;  // smallest number of voxels; with fewer, there is no metal
  if (metal.size() >= kMinMetal) {
    // Third quartile of the grey values of metal, because the borders of metal are too dark.
    greys.metal = nth(metal, metal.size() * 3 / 4);
  }
  greys.has_enamel = greys.enamel - offset > kDenser * (greys.hard - offset);
  return greys;
}

double noise_of(const Grid<float>& scan) {
  constexpr std::size_t kApart = 3, kEnough = 1'000'000;
  std::vector<float> differences;
  for (std::size_t i = 0; i + kApart < scan.v.size(); i += 1 + scan.v.size() / kEnough)
    differences.push_back(std::abs(scan.v[i + kApart] - scan.v[i]));
  return 1.4826 / std::sqrt(2.0) * nth(differences, differences.size() / 2);
}

JawLabels label_jaw(const Grid<float>& scan, const Segmentation& s, const JawGreys& greys, const CutWalls& walls,
                    double noise, double voxel, const std::function<void(double)>& progress) {
  const std::shared_ptr<const BlockSet>& set = s.grey.set;
  // Standard deviation of the smoothing, which reduces noise, and restores thin layers after blur.
  constexpr double kSmooth = 0.8;  // voxels
  const Sparse<float> grey = smooth_in_place(with_valleys(scan, s, greys), kSmooth, s.blur);
  const double mm3 = 1e-9 / cubed(voxel);  // samples per mm³
  JawLabels out{Sparse<Tissue>(set, Tissue::kAir, Tissue::kCancellousBone), {}};
  const auto mask = [&](auto test) { return where(set, false, false, test); };
  const auto brighter = [&](std::size_t i, double bound) { return static_cast<double>(grey.v[i]) > bound; };
  const SparseMask body = mask([&](std::size_t, const glm::ivec3& p) { return s.surface.distance[p] < 2; });

  // Masks of certain crown, of marrow, and of bright samples beside marrow. kMin…: smallest volume of a region, mm³.
  constexpr double kMinCrown = 8, kMinMarrow = 20;
  const SparseMask bright = mask([&](std::size_t i) { return body.v[i] && brighter(i, greys.bright()); });
  SparseMask crown(set, 0, 0);
  if (greys.has_enamel)
    crown = large_parts(mask([&](std::size_t i) { return body.v[i] && brighter(i, greys.crown()); }), kMinCrown * mm3);
  SparseMask not_marrow = mask([&](std::size_t i, const glm::ivec3& p) {
    return !brighter(i, greys.canal()) || brighter(i, greys.bright()) || s.surface.distance[p] >= -1;
  });
  not_marrow.outside = 1;
  const Sparse<float> to_rim = distance_squared_to(not_marrow, 2);
  const SparseMask marrow = large_parts(mask([&](std::size_t i) { return to_rim.v[i] > 2.25F; }), kMinMarrow * mm3);
  const Sparse<float> to_marrow = distance_squared_to(marrow, 3);
  const SparseMask beside_marrow = mask([&](std::size_t i) { return bright.v[i] && to_marrow.v[i] <= 6.25F; });
  // The bone's outer plate, far from crowns and from the volume's walls where they cut through the jaw.
  constexpr double kPlate = 1.2e-3, kFromCrown = 4e-3;  // m, thickness of the plate and smallest distance from crowns
  const int from_crown = static_cast<int>(std::clamp(kFromCrown / voxel, 2.0, 32.0));
  const Sparse<float> to_crown = distance_squared_to(crown, from_crown);
  const auto at_cut = [&](const glm::ivec3& p) {
    for (int a = 0; a < 3; ++a) {
      const auto& [lower, upper] = walls[static_cast<std::size_t>(a)];
      if (lower && (p[a] - *lower) * voxel < 1.5 * kPlate) return true;
      if (upper && (*upper - p[a]) * voxel < 1.5 * kPlate) return true;
    }
    return false;
  };
  const SparseMask plate = mask([&](std::size_t i, const glm::ivec3& p) {
    return bright.v[i] && !at_cut(p) && s.surface.distance[p] * voxel > -kPlate &&
           to_crown.v[i] > static_cast<float>(from_crown * from_crown);
  });
  progress(0.2);
  // Weights of a random walk's step into bone: small beside marrow, so that roots without a bright wall stay teeth;
  // small in the bone's outer plate, because roots may lie in it. kInPlate: distance from the crown, m.
  constexpr double kMarrow = 1e-3, kInPlate = 10e-3;
  const double in_plate = voxel * voxel / (kInPlate * kInPlate);
  Sparse<float> into_bone(set, 0, 0);
  for_each_sample(*set, [&](std::size_t i) {
    into_bone.v[i] = static_cast<float>(beside_marrow.v[i] ? std::max(kMarrow, in_plate) : plate.v[i] ? in_plate : 0);
  });
  // Residuals of two random walks. The first finds roots in the bone's outer plate. The second treats the rest as bone.
  constexpr double kRough = 1e-5, kFine = 1e-10;
  const Sparse<float> first = tooth_probability(grey, bright, crown, SparseMask(set, 0, 0), into_bone, greys, kRough,
                                                [&](double done) { progress(0.2 + 0.2 * done); });
  const SparseMask bone = mask([&](std::size_t i) { return plate.v[i] && first.v[i] < 0.5F; });
  const Sparse<float> probability = tooth_probability(grey, bright, crown, bone, into_bone, greys, kFine,
                                                      [&](double done) { progress(0.4 + 0.3 * done); });

  // Teeth include their cavities, also those with openings of one sample.
  const SparseMask tooth = mask([&](std::size_t i) { return bright.v[i] && probability.v[i] > 0.5F; });
  const Sparse<float> to_tooth = distance_squared_to(tooth, 2);
  const SparseMask roomy = where(set, true, true, [&](std::size_t i) { return to_tooth.v[i] > 1; });
  SparseMask reached = reached_from_walls(roomy).samples;
  reached.outside = reached.inside = 1;
  const Sparse<float> to_reached = distance_squared_to(reached, 2);
  const auto in_tooth = [&](std::size_t i) { return tooth.v[i] || to_reached.v[i] > 1; };

  progress(0.8);
  const SparseMask cancellous = mask([&](std::size_t i, const glm::ivec3& p) {
    return s.surface.distance[p] < -2 && !in_tooth(i) && to_tooth.v[i] > 4 && !brighter(i, greys.bright());
  });
  SparseMask canal(set, 0, 0);
  find_canals(grey, cancellous, greys, voxel, canal, out.report.canals);
  constexpr int kCanalReach = 5;  // voxels, largest distance of a canal's samples from its middle
  const Sparse<float> to_canal = distance_squared_to(canal, kCanalReach);

  // The canal: dark samples that are connected to its middle; other dark samples are noise.
  SparseMask core = mask([&](std::size_t i) {
    return cancellous.v[i] && to_canal.v[i] <= static_cast<float>(kCanalReach * kCanalReach) &&
           !brighter(i, greys.canal());
  });
  SparseMask nerve(set, 0, 0), nerve_wall(set, 0, 0);
  // `soft`: grey value of the measured nerve, or of water if no nerve is found. `brightest_soft`: grey value of the
  // brightest pulp. Without a measured nerve, it is kBrightestPulp Hounsfield units above water.
  constexpr double kBrightestPulp = 120;
  double soft = greys.soft, brightest_soft = greys.soft + kBrightestPulp;
  if (!out.report.canals.empty()) {
    const SparseComponents parts = components(core);
    std::vector<bool> of_canal(parts.voxels.size(), false);
    for (std::size_t i = 0; i < canal.v.size(); ++i) {
      if (canal.v[i] && core.v[i]) of_canal[static_cast<std::size_t>(parts.label.v[i])] = true;
    }
    core = mask([&](std::size_t i) { return core.v[i] && of_canal[static_cast<std::size_t>(parts.label.v[i])]; });
    if (const std::optional<double> inside = grey_inside(scan, core, s.true_blur)) soft = brightest_soft = *inside;
    const Sparse<float> to_core = distance_squared_to(core, 3);
    // Cortical bone is measured far from teeth, because dentin may be brighter.
    const auto own = [&](std::size_t i) { return grey.v[i]; };
    const auto deep = [&](std::size_t i) { return s.surface.distance[set->place(i)] < -2; };
    const double dense = std::max(median_of(plate, deep, own).value_or(greys.hard), greys.bright());
    const auto all = [](std::size_t) { return true; };
    const double porous = std::clamp(median_of(marrow, all, own).value_or(greys.cancellous), soft, dense);
    const Sparse<float> exact = smooth_in_place(s.grey, kSmooth, s.true_blur);
    const SparseMask beside = mask([&](std::size_t i) { return to_core.v[i] <= 9 && !in_tooth(i); });
    double length = 0, volume = 0;  // length (voxels) and volume (samples) of all canals
    for (const JawCanal& found : out.report.canals) {
      for (std::size_t k = 1; k < found.centre.size(); ++k)
        length += glm::length(found.centre[k] - found.centre[k - 1]);
    }
    for (const std::uint8_t in : core.v) volume += in;
    const double radius = std::max(2.0, std::sqrt(volume / (kPi * std::max(length, 1.0))));
    const CanalBound canal_bound(s.true_blur, kSmooth, (porous - soft) / (dense - soft), radius);
    // Brightest grey value of the canal's wall, searched in the direction in which grey values rise. If the opposite
    // direction does not lead into the canal, the rise is not the canal's wall, and the sample is skipped.
    const double without_wall = glm::mix(soft, dense, canal_bound(0));
    Sparse<float> brightest(set, 0, 0);
    for_each_sample(*set, [&](const glm::ivec3& p, std::size_t i) {
      if (!beside.v[i] || glm::any(glm::lessThan(p, glm::ivec3(1))) || glm::any(glm::greaterThan(p + 2, set->size)))
        return;
      constexpr double kLongest = 2.5, kStep = 0.5, kInto = 2;  // voxels: search range, step; depth tested in the canal
      const glm::dvec3 slope(exact(p.x + 1, p.y, p.z) - exact(p.x - 1, p.y, p.z),
                             exact(p.x, p.y + 1, p.z) - exact(p.x, p.y - 1, p.z),
                             exact(p.x, p.y, p.z + 1) - exact(p.x, p.y, p.z - 1));
      const double steep = glm::length(slope);
      if (!(steep > 0)) return;
      if (static_cast<double>(sample(exact, glm::dvec3(p) - kInto / steep * slope)) > without_wall) return;
      for (double t = kStep; t <= kLongest; t += kStep)
        brightest.v[i] = std::max(brightest.v[i], sample(exact, glm::dvec3(p) + t / steep * slope));
    });
    // Noise raises the largest of several values by this many standard deviations.
    constexpr double kMaxOfNoise = 0.5;
    const double excess = kMaxOfNoise * noise * noise_left(kSmooth, s.true_blur);
    const auto bound_at = [&](std::size_t i) {
      return glm::mix(soft, dense, canal_bound((static_cast<double>(brightest.v[i]) - excess - soft) / (dense - soft)));
    };
    nerve = mask([&](std::size_t i) {
      return beside.v[i] && cancellous.v[i] && to_core.v[i] <= 4 && static_cast<double>(exact.v[i]) < bound_at(i);
    });
    // Beside the nerve, samples that only blur has darkened belong to the canal's bright wall.
    const Sparse<float> to_nerve = distance_squared_to(nerve, 1);
    nerve_wall = mask([&](std::size_t i) {
      return beside.v[i] && to_nerve.v[i] <= 1 && static_cast<double>(brightest.v[i]) - excess > greys.bright();
    });
  }

  // At the border of dentin, the grey value is half-way between dentin and soft tissue; in thin layers, it is higher.
  const SparseMask near_tooth = mask([&](std::size_t i) { return to_tooth.v[i] <= 4 || in_tooth(i); });
  const LayerBound layer_bound;
  const Sparse<float> darkest = ball_min(grey, 2, near_tooth);
  const auto is_hard = [&](std::size_t i) {
    const double dip = (greys.hard - static_cast<double>(darkest.v[i])) / (greys.hard - greys.soft);
    return brighter(i, greys.hard - layer_bound(dip) * (greys.hard - greys.soft));
  };

  // Blurred edges of metal look like enamel. At the border of metal, the grey value is half-way between metal and the
  // darkest value within kBeside voxels.
  SparseMask metal(set, 0, 0);
  if (greys.metal) {
    constexpr int kBeside = 3;
    const SparseMask likely = mask([&](std::size_t i) { return brighter(i, 0.5 * (greys.hard + *greys.metal)); });
    const Sparse<float> beside = ball_min(grey, kBeside, likely);
    metal = mask([&](std::size_t i) {
      const double tissue = std::clamp(static_cast<double>(beside.v[i]), greys.hard, greys.enamel);
      return likely.v[i] && brighter(i, 0.5 * (tissue + *greys.metal));
    });
  }
  const Sparse<float> to_metal = distance_squared_to(metal, 3);

  constexpr double kLigament = 0.5e-3;  // m, largest width of the periodontal ligament
  const auto ligament = static_cast<float>(kLigament * kLigament / (voxel * voxel));
  for_each_sample(*set, [&](std::size_t i) {
    if (!body.v[i]) return;
    Tissue& t = out.tissue.v[i];
    if (metal.v[i]) {
      t = Tissue::kAmalgam;
    } else if (crown.v[i] && to_metal.v[i] > 6.25F) {
      t = Tissue::kEnamel;
    } else if (in_tooth(i) || (to_tooth.v[i] <= 1 && is_hard(i))) {
      const bool at_wall = tooth.v[i] && to_reached.v[i] <= 4;
      t = is_hard(i) ? Tissue::kDentin : at_wall ? Tissue::kGingiva : Tissue::kPulp;
    } else if (nerve.v[i]) {
      t = Tissue::kPulp;
    } else if (brighter(i, greys.bright()) || nerve_wall.v[i]) {
      t = Tissue::kCorticalBone;
    } else if (to_tooth.v[i] <= ligament && !is_hard(i)) {
      t = Tissue::kGingiva;
    } else {
      t = Tissue::kCancellousBone;
    }
  });

  correct_canals(scan, grey, where(set, false, false, [&](std::size_t i) { return in_tooth(i); }), to_crown, greys,
                 s.true_blur, soft, brightest_soft, out.tissue);

  out.report.border = voxel * border_uncertainty(noise / (greys.hard - greys.soft), s.blur);
  double mislabelled = 0;
  for (std::size_t i = 0; i < bright.v.size(); ++i) {
    if (const glm::ivec3 p = set->place(i); bright.v[i] && set->holds(p) && s.surface.distance[p] < 0)
      mislabelled += static_cast<double>(std::min(probability.v[i], 1 - probability.v[i]));
  }
  out.report.mislabelled = mislabelled * cubed(voxel);
  const SparseMask teeth = mask([&](std::size_t i, const glm::ivec3& p) {
    const Tissue t = out.tissue.v[i];
    if (s.surface.distance[p] >= 0) return false;
    return t == Tissue::kEnamel || t == Tissue::kDentin || t == Tissue::kAmalgam || (t == Tissue::kPulp && in_tooth(i));
  });
  out.report.teeth = find_teeth(teeth, crown, voxel, kMinCrown * mm3);
  for (JawTooth& found : out.report.teeth) found.volume *= cubed(voxel);
  return out;
}

}  // namespace typodont::haptics::importing
