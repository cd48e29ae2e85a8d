#include "haptics/import/segment.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "engine/base/quantile.h"
#include "engine/base/voxels.h"
#include "haptics/import/cavities.h"
#include "haptics/import/local_grey.h"
#include "haptics/import/tooth_borders.h"

namespace typodont::haptics::importing {

namespace {

constexpr double kStep = 0.5;  // voxels, length of the steps along rays
constexpr double kInfinity = std::numeric_limits<float>::max();

SparseMask above(const Sparse<float>& g, float bound) {
  return where(g.set, g.outside > bound, g.inside > bound, [&](std::size_t i) { return g.v[i] > bound; });
}

// Returns the number of the body to import, 0 if there is none. `tooth`: grey value above which voxels are tooth.
std::int32_t body_of(const SparseComponents& parts, const Sparse<float>& smooth, const std::optional<double>& tooth,
                     double voxel) {
  if (parts.voxels.size() < 2 || !tooth) return parts.largest();
  std::vector<Body> bodies(parts.voxels.size() - 1);
  for (std::size_t k = 0; k < bodies.size(); ++k) bodies[k].voxels = parts.voxels[k + 1];
  const auto bright = static_cast<float>(*tooth);
  for (std::size_t i = 0; i < smooth.v.size(); ++i) {
    const auto id = static_cast<std::size_t>(parts.label.v[i]);
    if (id > 0 && smooth.v[i] > bright && smooth.holds(smooth.place(i))) ++bodies[id - 1].bright;
  }
  return 1 + static_cast<std::int32_t>(main_body(bodies, Levels::kMinTeeth / (voxel * voxel * voxel)));
}

// Marks regions that have at least `fraction` of the largest region's voxels.
std::vector<bool> keep_large(const SparseComponents& parts, double fraction) {
  std::vector<bool> keep(parts.voxels.size(), false);
  const std::int32_t largest = parts.largest();
  if (largest == 0) return keep;
  for (std::size_t k = 1; k < keep.size(); ++k) {
    keep[k] = static_cast<double>(parts.voxels[k]) >=
              fraction * static_cast<double>(parts.voxels[static_cast<std::size_t>(largest)]);
  }
  return keep;
}

glm::dvec3 unit(const glm::dvec3& v) {
  const double l = glm::length(v);
  return l > 1e-12 ? v / l : glm::dvec3(0);
}

// Slope of a Gaussian edge where its value is `height` (0 to 1), divided by the slope at the edge's centre.
double steepness(double height) {
  // Finds the place of this value by bisection, in units of the edge's standard deviation.
  double lo = -3, hi = 3;
  for (int k = 0; k < 30; ++k) {
    const double middle = 0.5 * (lo + hi);
    (0.5 * std::erfc(-middle / std::sqrt(2.0)) < height ? lo : hi) = middle;
  }
  return std::exp(-0.5 * lo * lo);
}

// Unit normal, pointing outwards: along the line to the closest point; at the surface, along the gradient.
glm::dvec3 normal_at(const DistanceField& d, const glm::ivec3& i) {
  const glm::ivec3 hi = d.distance.set->size - 1;
  glm::dvec3 slope;
  for (int a = 0; a < 3; ++a) {
    glm::ivec3 p = i, m = i;
    p[a] = std::min(i[a] + 1, hi[a]);
    m[a] = std::max(i[a] - 1, 0);
    slope[a] = static_cast<double>(d.distance[p]) - static_cast<double>(d.distance[m]);
  }
  const double distance = d.distance[i];
  if (std::abs(distance) > 0.3) {
    const glm::dvec3 n = unit((glm::dvec3(i) - glm::dvec3(d.closest[i])) * (distance < 0 ? -1.0 : 1.0));
    if (glm::dot(n, n) > 0.5) return n;
  }
  return unit(slope);
}

// Depth of a sample below the surface, which determines the rules for its label.
enum Depth : std::uint8_t { kFar, kNear, kInSkin, kBelowSkin, kBelowShell };

// The steps of a segmentation in order. Each step frees data that no later step needs.
class Segmenter {
 public:
  Segmenter(const Grid<float>& grey, const Levels& levels, double voxel, ImportPreset preset,
            const std::optional<double>& band)
      : grey_(grey),
        levels_(levels),
        voxel_(voxel),
        preset_(preset),
        tooth_(preset == ImportPreset::kTooth),
        band_(band),
        rise_(levels.soft - levels.outside) {}

  Segmentation segment(const std::function<void(double)>& progress) {
    const auto report = [&](double done) {
      if (progress) progress(done);
    };
    smooth_greys();
    report(0.1);
    find_solid_and_cavities();
    report(0.25);
    first_ = signed_distance(over_, grey_.size, {}, kUsualShell + 0.5, kFirstExact);
    report(0.45);
    measure_edges();
    measure_greys();
    report(0.55);
    Sparse<float> occupancy = occupancy_of_samples();
    report(0.65);
    find_surface(std::move(occupancy));
    report(0.85);
    fill_greys();
    measure_cavity_grey();
    find_dense_tissue();
    find_cavity_tissue();
    if (tooth_) correct_tooth_borders();
    if (tooth_ && levels_.dense) relabel_isolated_parts();
    copy_labels_outward();
    s_.grey = std::move(filled_);
    report(1);
    return std::move(s_);
  }

 private:
  // Voxels. kSmooth: standard deviation of the smoothing. Shells: largest and usual distance that blur changes. Up to
  // kFirstExact, distances from the first surface are exact, so that edges can be measured there.
  static constexpr double kSmooth = 0.8, kWidestShell = 6, kUsualShell = 3.5, kFirstExact = 1.5;

  // Smooths the blocks with samples at least as bright as the tissue's surface, and the blocks beside them.
  void smooth_greys() {
    const auto surface_grey = static_cast<float>(levels_.surface()), outside = static_cast<float>(levels_.outside);
    set_ = std::make_shared<BlockSet>(
        grey_.size, with_neighbours(blocks_above(grey_, kSmooth, surface_grey), BlockSet::blocks_of(grey_.size)));
    smooth_ = gaussian(grey_, set_, kSmooth, outside, outside);
  }

  // Finds the first surface. Near denser tissue, the threshold is half-way from the surroundings to that tissue, so
  // that fissures stay open; but the threshold is always clearly below the softer tissue's grey value.
  void find_solid_and_cavities() {
    const double max_height = std::max(0.8, levels_.height);
    over_ = Sparse<float>(set_, -0.5F, 0.5F);
    {
      // Skips samples that are much darker than every possible threshold.
      const Sparse<float> brightest =
          ball_max(smooth_, 2, above(smooth_, static_cast<float>(levels_.surface() - 0.5 * rise_)));
      for_each_sample(*set_, [&](std::size_t i) {
        const double top = std::clamp<double>(brightest.v[i], levels_.soft, levels_.top());
        const double threshold =
            std::min(levels_.outside + levels_.height * (top - levels_.outside), levels_.outside + max_height * rise_);
        over_.v[i] = static_cast<float>((smooth_.v[i] - threshold) / rise_);
      });
    }
    SparseMask solid = where(set_, false, false, [&](std::size_t i) { return over_.v[i] > 0; });
    {
      const SparseComponents parts = components(solid);
      const std::int32_t body = body_of(parts, smooth_, levels_.tooth, voxel_);
      for_each_sample(*set_, [&](std::size_t i) { solid.v[i] = solid.v[i] && parts.label.v[i] == body; });
    }
    constexpr double kAir = -400;  // Hounsfield units; a space darker than this contains air
    SparseMask dense_mask(set_, 0, 0);
    if (levels_.dense) dense_mask = above(smooth_, static_cast<float>(levels_.denser()));
    // Width of the widest opening (mouth) of a cavity, voxels. Foramina of nerves in a jaw are wider than those of root
    // canals.
    const bool jaw = preset_ == ImportPreset::kJaw;
    const double widest_mouth = std::min((jaw ? 2.2e-3 : 0.75e-3) / voxel_, jaw ? 16.0 : 8.0);
    cavity_ = find_cavities(
        solid, dense_mask, widest_mouth, tooth_, set_,
        Hollows(smooth_, levels_.hounsfield ? std::optional(*levels_.hounsfield + kAir) : std::nullopt, voxel_),
        hollow_);
    for_each_sample(*set_, [&](std::size_t i) {
      const bool filled = solid.v[i] || cavity_.v[i];
      over_.v[i] = std::clamp(over_.v[i], -0.5F, 0.5F);
      if (cavity_.v[i]) over_.v[i] = 0.5F;
      if (!filled) over_.v[i] = std::min(over_.v[i], -0.01F);
    });
  }

  // Largest grey value from `from` inwards (against `n`), down to `depth` voxels.
  double inward_peak(const glm::dvec3& from, const glm::dvec3& n, double depth) const {
    float peak = sample(smooth_, from);
    for (double t = kStep; t <= depth; t += kStep) peak = std::max(peak, sample(smooth_, from - t * n));
    return static_cast<double>(peak);
  }

  // Measures the width of edges: the slope at the centre of an edge of height c is c / (σ √2π).
  void measure_edges() {
    // In a jaw, the slope is measured beside the edge's centre. This makes `widths` too large, which keeps the dark gap
    // between root and bone (ligament) open. `true_widths` are corrected.
    std::vector<float> widths, true_widths;
    for (std::size_t i = 0; i < first_.distance.v.size(); i += 3) {
      if (std::abs(first_.distance.v[i]) > 0.5F) continue;
      const glm::ivec3 p = first_.distance.place(i);
      if (!grey_.holds(p)) continue;
      const glm::dvec3 n = normal_at(first_, p);
      const double top = std::clamp(inward_peak(glm::dvec3(p), n, 4), levels_.soft, levels_.top());
      const Jet at = sample_cubic(smooth_, glm::dvec3(first_.closest.v[i]));
      const double slope = glm::length(at.gradient);
      if (!(slope > 0)) continue;
      widths.push_back(static_cast<float>((top - levels_.outside) / (std::sqrt(2 * M_PI) * slope)));
      if (preset_ == ImportPreset::kJaw)
        true_widths.push_back(widths.back() *
                              static_cast<float>(steepness((at.value - levels_.outside) / (top - levels_.outside))));
    }
    if (!widths.empty()) edge_ = std::clamp(nth(widths, widths.size() / 2), 0.8, 3.0);
    s_.blur = std::sqrt(std::max(0.0, edge_ * edge_ - kSmooth * kSmooth));
    s_.true_blur = s_.blur;
    if (!true_widths.empty()) {
      // A slope is a difference over two voxels, so an edge seems wider: σ² grows by 1/3 at samples, by 1/6 on average.
      constexpr double kInterpolation = 1.0 / 6;
      const double width = nth(true_widths, true_widths.size() / 2);
      s_.true_blur = std::sqrt(std::max(0.0, width * width - kSmooth * kSmooth - kInterpolation));
    }
    shell_ = std::clamp(2.5 * edge_, 2.5, kWidestShell);
    if (shell_ > kUsualShell) first_ = signed_distance(over_, grey_.size, {}, shell_ + 0.5, kFirstExact);
    over_ = {};
  }

  // Measures grey values: of the surroundings near each sample, and of enamel in its thick parts.
  void measure_greys() {
    // Uses only samples that lie farther out than the blurred edge, and outside other bodies.
    const auto surface_grey = static_cast<float>(levels_.surface());
    surroundings_.emplace([&](const glm::ivec3& p) { return static_cast<double>(grey_[p]); }, *set_, levels_.outside,
                          [&](const glm::ivec3& p, std::size_t i) {
                            return first_.distance[p] >= static_cast<float>(shell_) && smooth_.v[i] <= surface_grey;
                          });
    if (!tooth_ || !levels_.dense || levels_.fixed_dense) return;
    constexpr std::size_t kEnoughEnamel = 10;
    const auto denser = static_cast<float>(levels_.denser());
    enamel_grey_ = reference_grey(
        grey_,
        where(set_, false, false,
              [&](std::size_t i, const glm::ivec3& p) { return first_.distance[p] < 0 && smooth_.v[i] > denser; }),
        kEnoughEnamel, 1.4, std::max(kMinBlur, s_.blur));
  }

  // Fraction of tissue at each sample: 0 in the surroundings, 1 just below the surface and everywhere deeper, so that
  // dentin and pulp are solid.
  Sparse<float> occupancy_of_samples() {
    Sparse<float> occupancy(set_, 0, 1);
    for_each_sample(*set_, [&](const glm::ivec3& p, std::size_t i) {
      const double d = first_.distance[p];
      if (d >= shell_) return;
      if (d <= -shell_) {
        occupancy.v[i] = 1;
        return;
      }
      const glm::dvec3 n = normal_at(first_, p);
      const glm::dvec3 at = glm::dvec3(first_.closest[p]);
      const double top = std::clamp(inward_peak(at, n, shell_), levels_.soft, levels_.top());
      double low = surroundings_->at(p);
      if (levels_.fixed_surround) {
        // If thin soft tissue covers the bone, this tissue counts as the surroundings, and the air beyond it does not.
        double brightest_near = low;
        for (double t = 2 * edge_; t <= shell_; t += kStep)
          brightest_near = std::max<double>(brightest_near, sample(smooth_, at + t * n));
        low = std::max(low, std::min(levels_.outside, brightest_near));
      }
      const auto fraction = [&](double g) { return (g - low) / (top - low); };
      double o = fraction(grey_[p]);
      if (d < 0) {
        for (double t = 1; t < -d + 1; t += kStep) o = std::max(o, fraction(sample(smooth_, glm::dvec3(p) + t * n)));
        if (cavity_.v[i]) o = 1;
      }
      occupancy.v[i] = static_cast<float>(std::clamp(o, 0.0, 1.0));
    });
    first_ = DistanceField();
    return occupancy;
  }

  // Finds the final surface: smooths, removes other bodies, closes holes, computes distances.
  void find_surface(Sparse<float> occupancy) {
    // Chooses the smoothing: an edge must extend over several samples, and noise may move it by at most 0.02 voxel.
    double sigma = std::sqrt(std::max(1.1 * 1.1 - s_.blur * s_.blur, 0.7 * 0.7));
    for (; sigma < 2; sigma += 0.1) {
      const double left = levels_.noise / rise_ * noise_left(sigma, s_.blur);
      const double slope = 1 / (std::sqrt(2 * M_PI) * std::hypot(s_.blur, sigma));
      if (left / slope < 0.02) break;
    }
    s_.phi = smooth_in_place(std::move(occupancy), sigma, s_.blur);
    const auto height = static_cast<float>(levels_.height);
    s_.phi.outside -= height, s_.phi.inside -= height;
    for_each_sample(*set_, [&](std::size_t i) { s_.phi.v[i] -= height; });
    {
      const SparseComponents parts = components(above(s_.phi, 0));
      const std::int32_t body = body_of(parts, smooth_, levels_.tooth, voxel_);
      for_each_sample(*set_, [&](std::size_t i) {
        if (s_.phi.v[i] > 0 && parts.label.v[i] != body) s_.phi.v[i] = -0.01F;
      });
      s_.bodies_kept = body > 0;
    }
    close_holes();
    // Voxels. kLabelBand: up to this, the labels need distances. kLabelExact: up to this, distances are exact.
    constexpr double kLabelBand = 6, kLabelExact = 3;
    surface_band_ = std::max({shell_ + 0.5, kLabelBand, band_.value_or(0)});
    s_.surface = signed_distance(s_.phi, grey_.size, {}, surface_band_, std::max(kLabelExact, band_.value_or(0)));
    if (band_) s_.phi = {};
  }

  // Closes holes that smoothing opened; hollows of bone stay open.
  void close_holes() {
    const SparseMask open = where(set_, true, false, [&](std::size_t i) { return !(s_.phi.v[i] > 0); });
    const SparseMask reached = reached_from_walls(open).samples;
    const SparseComponents holes =
        components(where(set_, false, false, [&](std::size_t i) { return open.v[i] && !reached.v[i]; }));
    std::vector<bool> stays(holes.voxels.size(), false);
    for (std::size_t i = 0; i < hollow_.v.size(); ++i) {
      if (hollow_.v[i] && holes.label.v[i] > 0) stays[static_cast<std::size_t>(holes.label.v[i])] = true;
    }
    for_each_sample(*set_, [&](std::size_t i) {
      if (open.v[i] && !reached.v[i] && !stays[static_cast<std::size_t>(holes.label.v[i])]) s_.phi.v[i] = 0.01F;
    });
    hollow_ = {};
  }

  // In the tissue's dim outer edge, where labels would be wrong, replaces grey values by the brightest further inward.
  void fill_greys() {
    const double skin = std::min(shell_, 2 * edge_ + 0.5);
    const auto soft = static_cast<float>(levels_.soft);
    filled_ = Sparse<float>(set_, soft, soft);
    depth_ = Sparse<std::uint8_t>(set_, kFar, kBelowShell);
    for_each_sample(*set_, [&](const glm::ivec3& p, std::size_t i) {
      const double at = s_.surface.distance[p];
      depth_.v[i] = at > 3 ? kFar : at > 0 ? kNear : at > -skin ? kInSkin : at >= -shell_ ? kBelowSkin : kBelowShell;
      if (at < -skin) {
        filled_.v[i] = grey_[p];
      } else if (at < surface_band_) {
        const glm::dvec3 from = at > 0 ? glm::dvec3(s_.surface.closest[p]) : glm::dvec3(p);
        filled_.v[i] = static_cast<float>(inward_peak(from, normal_at(s_.surface, p), skin));
      } else {
        filled_.v[i] = soft;
      }
    });
  }

  // Measures the grey value of cavities at their centres, if cavities are wide enough.
  void measure_cavity_grey() {
    cavity_grey_ = levels_.outside;
    std::vector<float> greys, inner;
    const SparseMask wall = where(set_, true, false, [&](std::size_t i) { return !cavity_.v[i]; });
    const Sparse<float> to_wall = distance_squared_to(wall, static_cast<int>(2 * edge_) + 1);
    for (std::size_t i = 0; i < cavity_.v.size(); ++i) {
      if (!cavity_.v[i]) continue;
      greys.push_back(smooth_.v[i]);
      if (to_wall.v[i] > static_cast<float>(4 * edge_ * edge_)) inner.push_back(smooth_.v[i]);
    }
    std::vector<float>& told = inner.size() >= 20 ? inner : greys;
    if (!told.empty()) cavity_grey_ = nth(told, told.size() / (inner.size() >= 20 ? 2 : 10));
    smooth_ = {};
  }

  // Returns the grey values without the dim edge (filled_), limited to lo … hi and smoothed.
  Sparse<float> limited(double lo, double hi) const {
    Sparse<float> g(set_, filled_.outside, filled_.inside);
    for_each_sample(*set_, [&](std::size_t i) {
      g.v[i] = std::clamp(filled_.v[i], static_cast<float>(lo), static_cast<float>(hi));
    });
    return smooth_in_place(std::move(g), kSmooth, s_.blur);
  }

  // Finds the denser tissue: samples brighter than half-way between softer and denser tissue.
  void find_dense_tissue() {
    if (!levels_.dense) {
      s_.dense = Sparse<float>(set_, -0.5F, -0.5F);
      return;
    }
    Sparse<float> bright = limited(levels_.soft - 2 * levels_.noise, kInfinity);
    const auto denser = static_cast<float>(levels_.denser());
    const double dense = std::max(mode_of(bright, 0.03 * (*levels_.dense - levels_.soft),
                                          [&](std::size_t i) { return depth_.v[i] >= kInSkin && bright.v[i] > denser; })
                                      .value_or(*levels_.dense),
                                  levels_.denser());
    const double span = dense - levels_.soft, half = levels_.fixed_dense ? levels_.denser() : levels_.soft + 0.5 * span;
    // In a thin layer, which blur darkens, the threshold is half-way to the brightest value nearby, if that is clearly
    // brighter.
    const Sparse<float> peak =
        ball_max(bright, 2, where(set_, false, false, [&](std::size_t i) { return depth_.v[i] == kInSkin; }));
    const double faintest =
        levels_.fixed_dense ? kInfinity : levels_.soft + std::max(0.3 * span, 8 * levels_.smoothed_noise);
    s_.dense = std::move(bright);
    s_.dense.outside = s_.dense.inside = -0.5F;
    for_each_sample(*set_, [&](std::size_t i) {
      const auto here = static_cast<double>(s_.dense.v[i]);
      s_.dense.v[i] = -0.5F;
      if (depth_.v[i] < kInSkin) return;
      double bound = half;
      if (depth_.v[i] == kInSkin && peak.v[i] > static_cast<float>(faintest))
        bound = std::min(half, 0.5 * (levels_.soft + static_cast<double>(peak.v[i])));
      s_.dense.v[i] = static_cast<float>(std::clamp((here - bound) / span, -0.5, 0.5));
    });
    // Regions with less than 5 % (tooth) or 0.01 % of the largest region's voxels are noise.
    const SparseComponents parts = components(
        where(set_, false, false, [&](std::size_t i) { return depth_.v[i] >= kInSkin && s_.dense.v[i] > 0; }));
    const auto keep = keep_large(parts, tooth_ ? 0.05 : 1e-4);
    for (std::size_t i = 0; i < parts.label.v.size(); ++i) {
      const auto id = static_cast<std::size_t>(parts.label.v[i]);
      if (id > 0 && !keep[id]) s_.dense.v[i] = -0.1F;
    }
  }

  // Finds cavity tissue (pulp): samples below the blurred edge, darker than half-way from the softer tissue to the
  // cavity's grey value. In thin canals, which blur brightens, the darkest value nearby replaces the cavity's value.
  void find_cavity_tissue() {
    s_.cavity = limited(-kInfinity, levels_.soft + 2 * levels_.noise);
    const double drop = levels_.soft - cavity_grey_;
    constexpr float kNothing = 1e30F;
    Sparse<float> deep(set_, kNothing, kNothing);
    for_each_sample(*set_, [&](std::size_t i) {
      if (depth_.v[i] == kBelowShell || (cavity_.v[i] && depth_.v[i] >= kInSkin)) deep.v[i] = s_.cavity.v[i];
    });
    const Sparse<float> darkest =
        tooth_ ? ball_min(deep, std::clamp(2 * edge_, 2.0, 5.0),
                          where(set_, false, false, [&](std::size_t i) { return deep.v[i] < kNothing; }))
               : Sparse<float>();
    // Smallest contrast between a canal and dentin.
    const double least = std::max(0.25 * drop, 8 * levels_.smoothed_noise);
    pulp_ = SparseMask(set_, 0, 1);
    s_.cavity.outside = -0.5F, s_.cavity.inside = 0.5F;
    for_each_sample(*set_, [&](std::size_t i) {
      s_.cavity.v[i] = -0.5F;
      if (!(deep.v[i] < kNothing)) return;
      double bound = levels_.soft - 0.5 * drop;
      if (tooth_ && darkest.v[i] < static_cast<float>(levels_.soft - least))
        bound = 0.5 * (levels_.soft + std::max<double>(darkest.v[i], cavity_grey_));
      const double here = (bound - static_cast<double>(deep.v[i])) / drop;
      s_.cavity.v[i] = static_cast<float>(std::clamp(here, -0.5, 0.5));
      if (!tooth_ && !cavity_.v[i]) s_.cavity.v[i] = -0.5F;
      pulp_.v[i] = s_.cavity.v[i] > 0;
    });
    // Removes small regions, which are noise, and regions with more enamel than dentin around them, which are fissures.
    const SparseComponents parts = components(pulp_, true);
    std::vector<Contacts> faces(parts.voxels.size());
    for (std::size_t i = 0; i < pulp_.v.size(); ++i) {
      const auto id = static_cast<std::size_t>(parts.label.v[i]);
      if (id == 0) continue;
      for (const glm::ivec3& f : kFaceSteps) {
        const glm::ivec3 q = pulp_.place(i) + f;
        if (!pulp_.holds(q) || pulp_[q]) continue;
        ++faces[id].wall;
        faces[id].dense += s_.dense[q] > 0;
      }
    }
    std::vector<bool> keep(parts.voxels.size(), false);
    for (std::size_t k = 1; k < keep.size(); ++k) {
      keep[k] = parts.voxels[k] >= 40 && (!tooth_ || 2 * faces[k].dense < faces[k].wall);
      s_.cavity_parts += keep[k] ? 1 : 0;
    }
    for (std::size_t i = 0; i < pulp_.v.size(); ++i) {
      const auto id = static_cast<std::size_t>(parts.label.v[i]);
      if (id > 0 && !keep[id]) s_.cavity.v[i] = -0.1F, pulp_.v[i] = 0;
    }
  }

  // Corrects the borders of a tooth's tissues for blur and partial volume.
  void correct_tooth_borders() {
    const SparseMask enamel =
        where(set_, false, false, [&](std::size_t i) { return s_.dense.v[i] > 0 && !pulp_.v[i]; });
    match_tooth_volumes(grey_, s_, enamel, pulp_, levels_, enamel_grey_, cavity_grey_, *surroundings_);
    for_each_sample(*set_, [&](std::size_t i) { pulp_.v[i] = s_.cavity.v[i] > 0; });
  }

  // Dark spots in enamel and brightened parts of cavities get the label of their surroundings.
  void relabel_isolated_parts() {
    const SparseMask soft = where(set_, false, false, [&](std::size_t i) {
      return depth_.v[i] >= kInSkin && !(s_.dense.v[i] > 0) && !pulp_.v[i];
    });
    const SparseComponents parts = components(soft);
    const auto keep = keep_large(parts, 0.02);
    std::vector<Contacts> faces(parts.voxels.size());
    for (std::size_t i = 0; i < soft.v.size(); ++i) {
      const auto id = static_cast<std::size_t>(parts.label.v[i]);
      if (id == 0 || keep[id]) continue;
      for (const glm::ivec3& f : kFaceSteps) {
        const glm::ivec3 q = soft.place(i) + f;
        if (!soft.holds(q)) continue;
        faces[id].dense += s_.dense[q] > 0;
        faces[id].cavity += pulp_[q];
      }
    }
    for (std::size_t i = 0; i < soft.v.size(); ++i) {
      const auto id = static_cast<std::size_t>(parts.label.v[i]);
      if (id == 0 || keep[id]) continue;
      if (faces[id].dense > faces[id].cavity) s_.dense.v[i] = 0.1F;
      if (faces[id].cavity > faces[id].dense) s_.cavity.v[i] = 0.1F;
    }
  }

  // Samples just outside get the nearest label inside, because labels are interpolated at the surface.
  void copy_labels_outward() {
    for_each_sample(*set_, [&](const glm::ivec3& p, std::size_t i) {
      if (depth_.v[i] != kNear) return;
      const glm::dvec3 n = normal_at(s_.surface, p), on = glm::dvec3(s_.surface.closest[p]);
      for (const double below : {0.75, 1.5, 2.25}) {
        const glm::ivec3 near = glm::clamp(glm::ivec3(glm::round(on - below * n)), glm::ivec3(0), grey_.size - 1);
        if (depth_[near] < kInSkin) continue;
        s_.dense.v[i] = s_.dense[near];
        s_.cavity.v[i] = s_.cavity[near];
        break;
      }
    });
  }

  const Grid<float>& grey_;
  const Levels& levels_;
  double voxel_;  // m, edge of a voxel
  ImportPreset preset_;
  bool tooth_;
  std::optional<double> band_;
  double rise_;  // grey value of the softer tissue minus that of the surroundings

  Segmentation s_;
  std::shared_ptr<BlockSet> set_;
  Sparse<float> smooth_;     // smoothed grey values
  Sparse<float> over_;       // (smoothed grey value − local threshold) / `rise_`
  SparseMask cavity_;        // cavities inside the first surface
  SparseMask hollow_;        // spaces in bone that are not tissue (cavities.h)
  DistanceField first_;      // distances to the surface that find_solid_and_cavities() finds
  double edge_ = 1.2;        // standard deviation of smoothed edges, voxels
  double shell_ = 0;         // voxels, distance from the surface that blur changes
  double surface_band_ = 0;  // voxels, largest stored distance to the final surface
  std::optional<LocalGrey> surroundings_, enamel_grey_;
  Sparse<float> filled_;  // grey values in which fill_greys() has brightened the dim outer edge
  double cavity_grey_ = 0;
  Sparse<std::uint8_t> depth_;  // value of the enum Depth for each sample
  SparseMask pulp_;             // samples of cavity tissue (pulp)
};

}  // namespace

double border_uncertainty(double noise, double blur) {
  constexpr double kWithoutNoise = 0.1;  // voxels, measured error of a border's position in a scan without noise
  return std::hypot(kWithoutNoise, noise * std::sqrt(2 * M_PI) * std::max(0.5, blur));
}

Segmentation segment(const Grid<float>& grey, const Levels& levels, double voxel, ImportPreset preset,
                     const std::optional<double>& band, const std::function<void(double)>& progress) {
  return Segmenter(grey, levels, voxel, preset, band).segment(progress);
}

}  // namespace typodont::haptics::importing
