#include "haptics/import/segment.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "haptics/import/partial_volume.h"

namespace typodont::haptics::importing {

namespace {

constexpr double kStep = 0.5;  // voxels, length of the steps along rays
// voxels, smallest blur of a scan; the mean over a voxel alone is a blur of 0.3 voxels
constexpr double kLeastBlur = 0.4;

const std::array<glm::ivec3, 6> kFaces = {glm::ivec3(1, 0, 0), {-1, 0, 0}, {0, 1, 0},
                                          {0, -1, 0},          {0, 0, 1},  {0, 0, -1}};

// The contacts of a part with its surroundings: for each kind of neighbour, the number of the part's voxel faces that
// have a voxel of this kind on their other side.
struct Contacts {
  std::size_t mouth = 0, wall = 0, dense = 0, cavity = 0;
};

using Blocks = std::shared_ptr<const BlockSet>;

SparseMask above(const Sparse<float>& g, float bound) {
  return where(g.set, g.outside > bound, g.inside > bound,
               [&](std::size_t i, const glm::ivec3&) { return g.v[i] > bound; });
}

// Decides which closed spaces in a bone are hollows. A hollow is a space that contains air, or a space that is larger
// than the marrow space of any bone. All other closed spaces are marrow.
class Hollows {
 public:
  /// `air`: a space with a lower grey value contains air; no value if the scale of the grey values is unknown. `voxel`
  /// is in m.
  Hollows(const Sparse<float>& smooth, const std::optional<double>& air, double voxel)
      : smooth_(smooth), air_(air), largest_(kLargestMarrow / (voxel * voxel * voxel)) {}

  /// The result has one entry for each space: true if it is a hollow.
  std::vector<bool> operator()(const SparseComponents& spaces) const {
    constexpr std::size_t kLeast = 30;  // voxels; a space with fewer voxels than this is noise
    std::vector<bool> hollow(spaces.voxels.size(), false);
    std::vector<std::vector<float>> greys(spaces.voxels.size());
    for (std::size_t i = 0; i < spaces.label.v.size(); ++i) {
      if (const std::int32_t id = spaces.label.v[i]; id > 0 && smooth_.holds(smooth_.place(i)))
        greys[static_cast<std::size_t>(id)].push_back(smooth_.v[i]);
    }
    for (std::size_t id = 1; id < hollow.size(); ++id) {
      hollow[id] = static_cast<double>(spaces.voxels[id]) > largest_;
      if (!air_ || spaces.voxels[id] < kLeast || greys[id].empty()) continue;
      const auto middle = greys[id].begin() + static_cast<std::ptrdiff_t>(greys[id].size() / 2);
      std::nth_element(greys[id].begin(), middle, greys[id].end());
      hollow[id] = hollow[id] || static_cast<double>(*middle) < *air_;
    }
    return hollow;
  }

 private:
  // m³; a space larger than this is a hollow, because the marrow of a whole femur has only about 100 cm³
  static constexpr double kLargestMarrow = 150e-6;
  const Sparse<float>& smooth_;
  std::optional<double> air_;
  double largest_;
};

// Finds the cavities of the solid: spaces without a connection to the outside, or with only a narrow opening (mouth). A
// closed space in bone that contains air or is larger than any marrow space (the maxillary sinus, the inside of the
// skull) is not returned as a cavity but in `hollow`, so it does not become bone.
// Narrow mouths are found with a ball that moves from the walls of the box into all spaces in which it fits. The radius
// of the ball increases step by step up to `widest_mouth` (voxels). A pocket is a space that the ball cannot enter. If
// the area of its mouth is small compared with that of its wall, the pocket is a cavity (a root canal). Otherwise the
// pocket belongs to the outside (a fissure, the gap between two roots).
// The function also marks blocks of `set` that are not stored as inside, if they are not connected to the walls.
SparseMask find_cavities(const SparseMask& solid, const SparseMask& dense, double widest_mouth, bool tooth,
                         const std::shared_ptr<BlockSet>& set, const Hollows& hollows, SparseMask& hollow) {
  SparseMask outside, cavity(set, 0, 1);
  hollow = SparseMask(set, 0, 0);
  {
    const SparseMask open = where(set, true, true, [&](std::size_t i, const glm::ivec3&) { return !solid.v[i]; });
    Reached reached = reached_from_walls(open);
    outside = std::move(reached.samples);
    outside.outside = 1;
    if (!tooth) {
      const SparseMask closed =
          where(set, true, false, [&](std::size_t i, const glm::ivec3&) { return open.v[i] && !outside.v[i]; });
      const SparseComponents spaces = components(closed);
      const std::vector<bool> is_hollow = hollows(spaces);
      for (std::size_t b = 0; b < set->slot.size(); ++b) {
        const std::int32_t id = spaces.blocks[b];
        if (id > 0 && is_hollow[static_cast<std::size_t>(id)]) reached.blocks[b] = 1;
      }
      for_each_sample(*set, [&](const glm::ivec3&, std::size_t i) {
        if (!closed.v[i] || !is_hollow[static_cast<std::size_t>(spaces.label.v[i])]) return;
        hollow.v[i] = outside.v[i] = 1;
      });
    }
    for (std::size_t b = 0; b < set->slot.size(); ++b) {
      if (set->slot[b] == BlockSet::kOutside && !reached.blocks[b]) set->slot[b] = BlockSet::kInside;
    }
    for_each_sample(*set, [&](const glm::ivec3&, std::size_t i) { cavity.v[i] = open.v[i] && !outside.v[i]; });
  }

  const Sparse<float> clearance = distance_squared_to(solid, static_cast<int>(widest_mouth) + 1);
  // For radii above kFine, the steps are longer, because the rim of a mouth is then known well enough.
  constexpr double kFine = 8;  // voxels
  for (double r = 1; r <= widest_mouth; r += r < kFine ? 0.5 : 0.15 * r) {
    const SparseMask roomy = where(set, true, false, [&](std::size_t i, const glm::ivec3&) {
      return !solid.v[i] && !cavity.v[i] && clearance.v[i] > static_cast<float>(r * r);
    });
    SparseMask centres = reached_from_walls(roomy).samples;
    centres.outside = 1;
    const Sparse<float> from_centre = distance_squared_to(centres, static_cast<int>(r + 1) + 1);
    const SparseMask pocket = where(set, false, false, [&](std::size_t i, const glm::ivec3&) {
      return outside.v[i] && !hollow.v[i] && !cavity.v[i] && from_centre.v[i] > static_cast<float>((r + 1) * (r + 1));
    });
    const SparseComponents parts = components(pocket);
    // A pocket that contains air, for example a maxillary sinus with its narrow mouth, is not a cavity of a bone.
    const std::vector<bool> holds_air = tooth ? std::vector<bool>(parts.voxels.size(), false) : hollows(parts);
    std::vector<Contacts> faces(parts.voxels.size());
    for (std::size_t i = 0; i < pocket.v.size(); ++i) {
      const auto id = static_cast<std::size_t>(parts.label.v[i]);
      if (id == 0) continue;
      const glm::ivec3 p = pocket.place(i);
      for (const glm::ivec3& f : kFaces) {
        const glm::ivec3 q = p + f;
        if (!pocket.holds(q) || (outside[q] && !pocket[q] && !cavity[q])) {
          ++faces[id].mouth;
        } else if (cavity[q]) {
          ++faces[id].cavity;
        } else if (solid[q]) {
          ++faces[id].wall;
          faces[id].dense += dense[q];
        }
      }
    }
    for (std::size_t i = 0; i < pocket.v.size(); ++i) {
      const auto id = static_cast<std::size_t>(parts.label.v[i]);
      if (id == 0) continue;
      const Contacts& f = faces[id];
      const bool narrow =
          parts.voxels[id] >= 30 && static_cast<double>(f.mouth) < 0.04 * static_cast<double>(f.mouth + f.wall);
      // True if this pocket is only the mouth of a cavity that a smaller ball has already found.
      const bool plug = 2 * f.cavity > f.mouth;
      if ((narrow || plug) && !holds_air[id] && !(tooth && 2 * f.dense > f.wall + f.cavity)) cavity.v[i] = 1;
    }
  }
  return cavity;
}

// Returns the number of the connected part that is the body to import; 0 if there is no part. `tooth` is the grey value
// above which a voxel belongs to a tooth.
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
  return 1 + static_cast<std::int32_t>(main_body(bodies, Levels::kLeastTeeth / (voxel * voxel * voxel)));
}

// Marks all parts with at least the fraction `fraction` of the largest part's voxels.
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

// Returns the most frequent grey value of the samples for which counts(i) is true, or no value if there are too few. In
// a large volume, only every n-th sample is used.
template <class Counts>
std::optional<double> mode_of(const Sparse<float>& greys, double width, Counts counts) {
  constexpr std::size_t kEnough = 20'000'000;
  std::vector<float> values;
  for (std::size_t i = 0; i < greys.v.size(); i += 1 + greys.v.size() / kEnough) {
    if (counts(i)) values.push_back(greys.v[i]);
  }
  if (values.size() < 50) return std::nullopt;
  std::sort(values.begin(), values.end());
  std::size_t best = 0, lo = 0;
  double mode = static_cast<double>(values.back());
  for (std::size_t hi = 0; hi < values.size(); ++hi) {
    while (values[hi] - values[lo] > static_cast<float>(2 * width)) ++lo;
    if (hi - lo > best)
      best = hi - lo, mode = 0.5 * (static_cast<double>(values[lo]) + static_cast<double>(values[hi]));
  }
  return mode;
}

glm::dvec3 unit(const glm::dvec3& v) {
  const double l = glm::length(v);
  return l > 1e-12 ? v / l : glm::dvec3(0);
}

// Finds the grey value of a tissue or of the surroundings near a sample: the mean over cells of 4³ samples, which is
// then smoothed. If hardly any samples nearby belong to the tissue or the surroundings (in a fissure), it is the mean
// grey value in the whole scan.
class LocalGrey {
 public:
  /// `grey` returns the grey value of a sample. `counts` returns true for the samples that are used.
  template <class Grey, class Counts>
  LocalGrey(Grey grey, const BlockSet& set, double everywhere, Counts counts)
      : everywhere_(everywhere), sum_((set.size + 3) / 4, 0.0F), weight_(sum_.size, 0.0F) {
    // The loop runs in parallel over blocks. Each cell lies in a single block, so two threads never write the same
    // cell.
    for_each_sample(set, [&](const glm::ivec3& p, std::size_t i) {
      if (!counts(p, i)) return;
      const glm::ivec3 cell = p / 4;
      sum_[cell] += static_cast<float>((grey(p) - everywhere) / 64);
      weight_[cell] += 1.0F / 64;
    });
    // Standard deviation of the smoothing, in units of cells. Together with the mean over a cell and the interpolation
    // between cells, the smoothing then has a standard deviation of about four samples.
    constexpr double kSigma = 0.87;
    sum_ = gaussian(sum_, kSigma);
    weight_ = gaussian(weight_, kSigma);
  }
  double at(const glm::ivec3& p) const {
    const glm::dvec3 q = (glm::dvec3(p) - 1.5) / 4.0;
    // Weight of the mean grey value in the whole scan. For comparison: the samples nearby have the weight 1 if all of
    // them are used.
    constexpr double kOfEverywhere = 0.02;
    return everywhere_ +
           static_cast<double>(sample(sum_, q)) / (static_cast<double>(sample(weight_, q)) + kOfEverywhere);
  }

 private:
  double everywhere_;
  Grid<float> sum_, weight_;
};

// Returns the slope of a Gaussian edge where it has risen to the fraction `height` of its full height, relative to its
// slope at the centre.
double steepness(double height) {
  // Finds by bisection the position at which the edge has risen to `height`. Unit: the edge's standard deviation.
  double lo = -3, hi = 3;
  for (int k = 0; k < 30; ++k) {
    const double middle = 0.5 * (lo + hi);
    (0.5 * std::erfc(-middle / std::sqrt(2.0)) < height ? lo : hi) = middle;
  }
  return std::exp(-0.5 * lo * lo);
}

// Returns the unit normal that points outward at a sample. It is the direction between the sample and its closest point
// on the surface. On the surface itself, it is the gradient of the distance.
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

// Returns the mean grey value of the samples of `tissue` that are far from its border: first the mean of all such
// samples, then the local mean near each sample. Returns no value if there are fewer than `enough` such samples at the
// distance `least` (voxels) or more. `blur` is the standard deviation of the scan's blur in voxels. At the distance z ·
// blur from an edge, a Gaussian blur changes the grey value by Φ(−z) times the height of the edge, and the sum of the
// second derivatives is z φ(z) / blur² times this height. The change of the grey value is computed from this sum and
// removed. If `blur` is 0, the grey values are used unchanged.
std::optional<LocalGrey> reference_grey(const Grid<float>& grey, const SparseMask& tissue, std::size_t enough,
                                        double least, double blur) {
  const std::shared_ptr<const BlockSet>& set = tissue.set;
  const SparseMask others = where(set, true, true, [&](std::size_t i, const glm::ivec3&) { return !tissue.v[i]; });
  const Sparse<float> away = distance_squared_to(others, 4);
  const auto sharp = [&](const glm::ivec3& p) {
    const auto here = static_cast<double>(grey[p]);
    if (blur == 0) return here;
    double rise = 0;
    for (const glm::ivec3& f : kFaces) rise += static_cast<double>(grey[p + f]) - here;
    // The border lies half a voxel before the nearest sample outside.
    const double z = std::clamp((std::sqrt(static_cast<double>(away[p])) - 0.5) / blur, 0.5, 6.0);
    const double density = std::exp(-0.5 * z * z) / std::sqrt(2 * M_PI);
    return here - blur * blur * rise * 0.5 * std::erfc(z / std::sqrt(2.0)) / (z * density);
  };
  // If there are too few samples at a larger distance from the border, samples at a smaller one are used.
  for (const double far : {3.0, 2.5, 2.0, 1.5, 1.4}) {
    if (far < least) break;
    const auto counts = [&](const glm::ivec3&, std::size_t i) { return away.v[i] >= static_cast<float>(far * far); };
    double sum = 0;
    std::size_t count = 0;
    for (std::size_t i = 0; i < away.v.size(); ++i) {
      const glm::ivec3 p = set->place(i);
      if (tissue.v[i] && set->holds(p) && counts(p, i)) sum += sharp(p), ++count;
    }
    if (count >= enough) return LocalGrey(sharp, *set, sum / static_cast<double>(count), counts);
  }
  return std::nullopt;
}

// Returns the mean curvature, per voxel, of the surface of constant distance through a sample; positive if the body is
// convex there. The curvature is limited, because the distance has no curvature at an edge.
double curvature_at(const Sparse<float>& distance, const glm::ivec3& p) {
  constexpr double kMost = 0.5;
  const glm::ivec3 hi = distance.set->size - 1;
  double sum = 0;
  for (const glm::ivec3& f : kFaces)
    sum += static_cast<double>(distance[glm::clamp(p + f, glm::ivec3(0), hi)]) - static_cast<double>(distance[p]);
  return std::clamp(0.5 * sum, -kMost, kMost);
}

// Moves the borders of enamel and pulp in a tooth until their volumes agree with the grey values (partial_volume.h).
// `enamel_grey` has no value if the grey value of enamel is unknown. `pulp_grey` is used if no pulp is wide enough to
// measure its grey value.
void match_tooth_volumes(const Grid<float>& grey, Segmentation& s, const SparseMask& enamel, const SparseMask& pulp,
                         const Levels& levels, const std::optional<LocalGrey>& enamel_grey, double pulp_grey,
                         const LocalGrey& outside) {
  // In voxels: distance from a border within which blur changes the grey values; distance from the surface within which
  // the surroundings change them.
  constexpr float kBlurred = 2.5F;
  constexpr double kOutside = 3;
  constexpr double kLeast = -0.25, kMost = 1.25;  // limits of a fraction, which noise can make wrong
  const std::shared_ptr<const BlockSet>& set = s.dense.set;
  const Sparse<float>& d = s.surface.distance;
  const double blur = std::max(kLeastBlur, s.blur);
  const SparseMask body = where(set, false, false, [&](std::size_t, const glm::ivec3& p) { return d[p] <= 0; });
  const SparseMask dentin = where(
      set, false, true, [&](std::size_t i, const glm::ivec3&) { return body.v[i] && !enamel.v[i] && !pulp.v[i]; });
  constexpr std::size_t kEnoughDentin = 200, kEnoughPulp = 5;
  const std::optional<LocalGrey> dentin_grey = reference_grey(grey, dentin, kEnoughDentin, 2, blur),
                                 own_pulp_grey = reference_grey(grey, pulp, kEnoughPulp, 1.4, 0);
  const Sparse<float> to_enamel = distance_squared_to(enamel, 4), to_pulp = distance_squared_to(pulp, 4),
                      to_dentin = distance_squared_to(dentin, 4);
  // `usual` is the difference between the grey values of the tissue and of dentin in the whole scan.
  const auto match = [&](Sparse<float>& field, const SparseMask& tissue, const Sparse<float>& to_tissue,
                         const Sparse<float>& to_other, double usual, auto own_grey) {
    constexpr float kReach = kBlurred * kBlurred;
    constexpr double kLeastContrast = 0.3;  // smallest local difference, as a fraction of the usual one
    const SparseMask others = where(set, true, true, [&](std::size_t i, const glm::ivec3&) { return !tissue.v[i]; });
    const Sparse<float> into = distance_squared_to(others, 4);
    Sparse<float> fraction(set, 0, 0);
    SparseMask border(set, 0, 0);
    for_each_sample(*set, [&](const glm::ivec3& p, std::size_t i) {
      const double at = d[p];
      if (to_tissue.v[i] > kReach || to_other.v[i] < to_tissue.v[i] || at > kOutside) return;
      border.v[i] = body.v[i] && to_dentin.v[i] <= kReach;
      if (into.v[i] > kReach) {
        fraction.v[i] = 1;
        return;
      }
      // Grey value that the sample would have if the tooth consisted only of dentin. The blur of a convex surface has
      // the effect of a displacement of the surface inward.
      const double of_dentin = dentin_grey ? dentin_grey->at(p) : levels.soft;
      const double displaced = at + blur * blur * curvature_at(d, p);
      const double without = glm::mix(of_dentin, outside.at(p), 0.5 * std::erfc(-displaced / (std::sqrt(2.0) * blur)));
      const double contrast = usual * std::max(kLeastContrast, (own_grey(p) - of_dentin) / usual);
      const double found = (static_cast<double>(grey[p]) - without) / contrast;
      fraction.v[i] = static_cast<float>(std::clamp(found, kLeast, kMost));
    });
    match_volume(field, fraction, border, body, blur);
  };
  if (enamel_grey && levels.top() > levels.soft)
    match(s.dense, enamel, to_enamel, to_pulp, levels.top() - levels.soft,
          [&](const glm::ivec3& p) { return enamel_grey->at(p); });
  if (pulp_grey < levels.soft)
    match(s.cavity, pulp, to_pulp, to_enamel, pulp_grey - levels.soft,
          [&](const glm::ivec3& p) { return own_pulp_grey ? own_pulp_grey->at(p) : pulp_grey; });
}

}  // namespace

double border_uncertainty(double noise, double blur) {
  constexpr double kWithoutNoise = 0.1;  // voxels, error of a border's position without noise, as measured
  return std::hypot(kWithoutNoise, noise * std::sqrt(2 * M_PI) * std::max(0.5, blur));
}

Segmentation segment(const Grid<float>& grey, const Levels& levels, double voxel, ImportPreset preset,
                     const std::optional<double>& band, const std::function<void(double)>& progress) {
  const auto report = [&](double done) {
    if (progress) progress(done);
  };
  const bool tooth = preset == ImportPreset::kTooth;
  Segmentation s;
  // Difference between the grey values of the softer tissue and the surroundings.
  const double rise = levels.soft - levels.outside;
  const glm::ivec3 size = grey.size;

  // Smooths the grey values. Only blocks with samples as bright as the surface, and the neighbours of these blocks, are
  // computed. kSmooth is the standard deviation in voxels.
  constexpr double kSmooth = 0.8;
  const auto surface_grey = static_cast<float>(levels.surface());
  const auto blocks = std::make_shared<BlockSet>(
      size, with_neighbours(blocks_above(grey, kSmooth, surface_grey), BlockSet::blocks_of(size)));
  const Blocks set = blocks;
  const auto outside_grey = static_cast<float>(levels.outside);
  Sparse<float> smooth = gaussian(grey, set, kSmooth, outside_grey, outside_grey);
  report(0.1);

  // Computes a first surface. Near a denser tissue, the threshold is halfway between the surroundings and that
  // tissue, so that fissures in enamel stay open. The threshold is always clearly below the grey value of the softer
  // tissue.
  const double most_height = std::max(0.8, levels.height);
  Sparse<float> over(set, -0.5F, 0.5F);  // smoothed grey value minus the local threshold, divided by `rise`
  {
    // Samples far below every possible threshold are skipped, because for them the brightest neighbour is not needed.
    const Sparse<float> brightest =
        ball_max(smooth, 2, above(smooth, static_cast<float>(levels.surface() - 0.5 * rise)));
    for_each_sample(*set, [&](const glm::ivec3&, std::size_t i) {
      const double top = std::clamp<double>(brightest.v[i], levels.soft, levels.top());
      const double threshold =
          std::min(levels.outside + levels.height * (top - levels.outside), levels.outside + most_height * rise);
      over.v[i] = static_cast<float>((smooth.v[i] - threshold) / rise);
    });
  }
  SparseMask solid = where(set, false, false, [&](std::size_t i, const glm::ivec3&) { return over.v[i] > 0; });
  {
    const SparseComponents parts = components(solid);
    const std::int32_t body = body_of(parts, smooth, levels.tooth, voxel);
    for_each_sample(*set,
                    [&](const glm::ivec3&, std::size_t i) { solid.v[i] = solid.v[i] && parts.label.v[i] == body; });
  }
  SparseMask cavity, hollow;
  {
    constexpr double kAir = -400;  // Hounsfield units; a space darker than this contains air
    SparseMask dense_mask(set, 0, 0);
    if (levels.dense) dense_mask = above(smooth, static_cast<float>(levels.denser()));
    // Largest radius of the mouth of a cavity: m, and voxels. In a jaw, the nerve canals are open at their foramina,
    // which are wider than the mouths of root canals.
    const bool jaw = preset == ImportPreset::kJaw;
    const double widest_mouth = std::min((jaw ? 2.2e-3 : 0.75e-3) / voxel, jaw ? 16.0 : 8.0);
    cavity = find_cavities(
        solid, dense_mask, widest_mouth, tooth, blocks,
        Hollows(smooth, levels.hounsfield ? std::optional(*levels.hounsfield + kAir) : std::nullopt, voxel), hollow);
  }
  for_each_sample(*set, [&](const glm::ivec3&, std::size_t i) {
    const bool filled = solid.v[i] || cavity.v[i];
    over.v[i] = std::clamp(over.v[i], -0.5F, 0.5F);
    if (cavity.v[i]) over.v[i] = 0.5F;
    if (!filled) over.v[i] = std::min(over.v[i], -0.01F);
  });
  solid = {};
  report(0.25);

  // In voxels. kWidestShell: largest distance from the surface at which the blurred edge is assumed to change grey
  // values. kUsualShell: the edge of most scans changes grey values only up to this distance. kFirstExact: distances
  // are exact up to this one, because the measurement of the edges' width needs exact distances.
  constexpr double kWidestShell = 6, kUsualShell = 3.5, kFirstExact = 1.5;
  DistanceField first = signed_distance(over, size, {}, kUsualShell + 0.5, kFirstExact);
  report(0.45);

  // Measures the width σ of the scan's edges. At its centre, a Gaussian edge with the height c has the slope c / (σ
  // √2π). inward_peak() returns the largest grey value along the normal.
  const auto inward_peak = [&](const glm::dvec3& from, const glm::dvec3& n, double depth) {
    float peak = sample(smooth, from);
    for (double t = kStep; t <= depth; t += kStep) peak = std::max(peak, sample(smooth, from - t * n));
    return static_cast<double>(peak);
  };
  // In a jaw, the first surface does not lie at the middle of the blurred edge: its threshold is based on cancellous
  // bone, but cortical bone is brighter. The edge is less steep there, so `widths` are too large. They are still used
  // for the sharpening, because a stronger sharpening keeps the periodontal ligament open. `true_widths` are corrected.
  std::vector<float> widths, true_widths;
  for (std::size_t i = 0; i < first.distance.v.size(); i += 3) {
    if (std::abs(first.distance.v[i]) > 0.5F) continue;
    const glm::ivec3 p = first.distance.place(i);
    if (!grey.holds(p)) continue;
    const glm::dvec3 n = normal_at(first, p);
    const double top = std::clamp(inward_peak(glm::dvec3(p), n, 4), levels.soft, levels.top());
    const Jet at = sample_cubic(smooth, glm::dvec3(first.closest.v[i]));
    const double slope = glm::length(at.gradient);
    if (!(slope > 0)) continue;
    widths.push_back(static_cast<float>((top - levels.outside) / (std::sqrt(2 * M_PI) * slope)));
    if (preset == ImportPreset::kJaw)
      true_widths.push_back(widths.back() *
                            static_cast<float>(steepness((at.value - levels.outside) / (top - levels.outside))));
  }
  double edge = 1.2;  // width σ, in voxels, of the edges in the smoothed grey values
  if (!widths.empty()) {
    std::nth_element(widths.begin(), widths.begin() + static_cast<std::ptrdiff_t>(widths.size() / 2), widths.end());
    edge = std::clamp<double>(widths[widths.size() / 2], 0.8, 3);
  }
  s.blur = std::sqrt(std::max(0.0, edge * edge - kSmooth * kSmooth));
  s.true_blur = s.blur;
  if (!true_widths.empty()) {
    const auto middle = true_widths.begin() + static_cast<std::ptrdiff_t>(true_widths.size() / 2);
    std::nth_element(true_widths.begin(), middle, true_widths.end());
    // The gradient is interpolated from differences of samples two voxels apart. At a sample, this increases the
    // variance σ² of the edge by 1/3; between samples, it hardly changes σ². The constant is the mean of both cases.
    constexpr double kInterpolation = 1.0 / 6;
    const auto width = static_cast<double>(*middle);
    s.true_blur = std::sqrt(std::max(0.0, width * width - kSmooth * kSmooth - kInterpolation));
  }
  // Distance in voxels on each side of the surface within which the blurred edge changes the grey values.
  const double shell = std::clamp(2.5 * edge, 2.5, kWidestShell);
  if (shell > kUsualShell) first = signed_distance(over, size, {}, shell + 0.5, kFirstExact);
  over = {};

  // Measures the grey value of the surroundings near each sample. Only voxels that lie beyond the blurred edge and
  // outside other bodies are used.
  const LocalGrey surround([&](const glm::ivec3& p) { return static_cast<double>(grey[p]); }, *set, levels.outside,
                           [&](const glm::ivec3& p, std::size_t i) {
                             return first.distance[p] >= static_cast<float>(shell) && smooth.v[i] <= surface_grey;
                           });
  // Measures the grey value of enamel in its thick parts.
  std::optional<LocalGrey> enamel_grey;
  if (tooth && levels.dense && !levels.fixed_dense) {
    constexpr std::size_t kEnoughEnamel = 10;
    const auto denser = static_cast<float>(levels.denser());
    enamel_grey = reference_grey(
        grey,
        where(set, false, false,
              [&](std::size_t i, const glm::ivec3& p) { return first.distance[p] < 0 && smooth.v[i] > denser; }),
        kEnoughEnamel, 1.4, std::max(kLeastBlur, s.blur));
  }
  report(0.55);

  // Computes the occupancy: the grey value on a scale from the surroundings (0) to the tissue just below the surface
  // (1). Along the path inward, the occupancy stays 1 after the brightest point. So darker tissue further inward counts
  // as solid: dentin below enamel, and pulp.
  Sparse<float> occupancy(set, 0, 1);
  for_each_sample(*set, [&](const glm::ivec3& p, std::size_t i) {
    const double d = first.distance[p];
    if (d >= shell) return;
    if (d <= -shell) {
      occupancy.v[i] = 1;
      return;
    }
    const glm::dvec3 n = normal_at(first, p);
    const glm::dvec3 at = glm::dvec3(first.closest[p]);
    const double top = std::clamp(inward_peak(at, n, shell), levels.soft, levels.top());
    double low = surround.at(p);
    if (levels.fixed_surround) {
      // If a thin layer of soft tissue covers the bone, this layer counts as the surroundings, and the air beyond it
      // does not.
      double brightest_near = low;
      for (double t = 2 * edge; t <= shell; t += kStep)
        brightest_near = std::max<double>(brightest_near, sample(smooth, at + t * n));
      low = std::max(low, std::min(levels.outside, brightest_near));
    }
    const auto fraction = [&](double g) { return (g - low) / (top - low); };
    double o = fraction(grey[p]);
    if (d < 0) {
      for (double t = 1; t < -d + 1; t += kStep) o = std::max(o, fraction(sample(smooth, glm::dvec3(p) + t * n)));
      if (cavity.v[i]) o = 1;
    }
    occupancy.v[i] = static_cast<float>(std::clamp(o, 0.0, 1.0));
  });
  report(0.65);

  first = DistanceField();

  // Selects the strength of the smoothing. An edge must extend over several samples, and noise may displace the surface
  // by at most 0.02 voxel.
  double sigma = std::sqrt(std::max(1.1 * 1.1 - s.blur * s.blur, 0.7 * 0.7));
  for (; sigma < 2; sigma += 0.1) {
    const double left = levels.noise / rise * noise_left(sigma, s.blur);
    const double slope = 1 / (std::sqrt(2 * M_PI) * std::hypot(s.blur, sigma));
    if (left / slope < 0.02) break;
  }
  s.phi = smooth_in_place(std::move(occupancy), sigma, s.blur);
  const auto height = static_cast<float>(levels.height);
  s.phi.outside -= height, s.phi.inside -= height;
  for_each_sample(*set, [&](const glm::ivec3&, std::size_t i) { s.phi.v[i] -= height; });

  // Keeps one body of the segmentation, and closes holes inside it that the smoothing may have opened. Hollows are not
  // closed.
  {
    const SparseComponents parts = components(above(s.phi, 0));
    const std::int32_t body = body_of(parts, smooth, levels.tooth, voxel);
    for_each_sample(*set, [&](const glm::ivec3&, std::size_t i) {
      if (s.phi.v[i] > 0 && parts.label.v[i] != body) s.phi.v[i] = -0.01F;
    });
    s.bodies_kept = body > 0;
  }
  {
    const SparseMask open =
        where(set, true, false, [&](std::size_t i, const glm::ivec3&) { return !(s.phi.v[i] > 0); });
    const SparseMask reached = reached_from_walls(open).samples;
    const SparseComponents holes = components(
        where(set, false, false, [&](std::size_t i, const glm::ivec3&) { return open.v[i] && !reached.v[i]; }));
    std::vector<bool> stays(holes.voxels.size(), false);
    for (std::size_t i = 0; i < hollow.v.size(); ++i) {
      if (hollow.v[i] && holes.label.v[i] > 0) stays[static_cast<std::size_t>(holes.label.v[i])] = true;
    }
    for_each_sample(*set, [&](const glm::ivec3&, std::size_t i) {
      if (open.v[i] && !reached.v[i] && !stays[static_cast<std::size_t>(holes.label.v[i])]) s.phi.v[i] = 0.01F;
    });
    hollow = {};
  }
  // Limits in voxels for the distances that the labels need: largest distance, and distance up to which it is exact.
  // Labels are also read and smoothed outside the surface.
  constexpr double kLabelBand = 6, kLabelExact = 3;
  const double surface_band = std::max({shell + 0.5, kLabelBand, band.value_or(0)});
  s.surface = signed_distance(s.phi, size, {}, surface_band, std::max(kLabelExact, band.value_or(0)));
  if (band) s.phi = {};
  const Sparse<float>& d = s.surface.distance;
  report(0.85);

  // Computes grey values for the labels, without the dim outer edge. Within the edge and outside, each sample gets the
  // brightest grey value further inward. Without this, enamel and dentin would get a layer of wrong labels.
  const double skin = std::min(shell, 2 * edge + 0.5);
  Sparse<float> filled(set, static_cast<float>(levels.soft), static_cast<float>(levels.soft));
  for_each_sample(*set, [&](const glm::ivec3& p, std::size_t i) {
    const double at = d[p];
    if (at < -skin) {
      filled.v[i] = grey[p];
    } else if (at < surface_band) {
      const glm::dvec3 from = at > 0 ? glm::dvec3(s.surface.closest[p]) : glm::dvec3(p);
      filled.v[i] = static_cast<float>(inward_peak(from, normal_at(s.surface, p), skin));
    } else {
      filled.v[i] = static_cast<float>(levels.soft);
    }
  });
  // Measures the grey value of the cavities. If they are wide enough, only samples at their centres are used.
  double cavity_grey = levels.outside;
  {
    std::vector<float> greys, inner;
    const SparseMask wall = where(set, true, false, [&](std::size_t i, const glm::ivec3&) { return !cavity.v[i]; });
    const Sparse<float> to_wall = distance_squared_to(wall, static_cast<int>(2 * edge) + 1);
    for (std::size_t i = 0; i < cavity.v.size(); ++i) {
      if (!cavity.v[i]) continue;
      greys.push_back(smooth.v[i]);
      if (to_wall.v[i] > static_cast<float>(4 * edge * edge)) inner.push_back(smooth.v[i]);
    }
    std::vector<float>& told = inner.size() >= 20 ? inner : greys;
    if (!told.empty()) {
      const auto k = static_cast<std::ptrdiff_t>(told.size() / (inner.size() >= 20 ? 2 : 10));
      std::nth_element(told.begin(), told.begin() + k, told.end());
      cavity_grey = told[static_cast<std::size_t>(k)];
    }
  }
  smooth = {};
  const auto limited = [&](double lo, double hi) {
    Sparse<float> g(set, filled.outside, filled.inside);
    for_each_sample(*set, [&](const glm::ivec3&, std::size_t i) {
      g.v[i] = std::clamp(filled.v[i], static_cast<float>(lo), static_cast<float>(hi));
    });
    return smooth_in_place(std::move(g), kSmooth, s.blur);
  };
  constexpr double kInfinity = std::numeric_limits<float>::max();

  // Finds the denser tissue: samples brighter than halfway between the softer and the denser tissue. Different rules
  // apply at different depths below the surface, so each sample gets a depth class.
  enum Depth : std::uint8_t { kFar, kNear, kInSkin, kBelowSkin, kBelowShell };
  Sparse<std::uint8_t> depth(set, kFar, kBelowShell);
  for_each_sample(*set, [&](const glm::ivec3& p, std::size_t i) {
    const double at = d[p];
    depth.v[i] = at > 3 ? kFar : at > 0 ? kNear : at > -skin ? kInSkin : at >= -shell ? kBelowSkin : kBelowShell;
  });
  if (!levels.dense) {
    s.dense = Sparse<float>(set, -0.5F, -0.5F);
  } else {
    Sparse<float> bright = limited(levels.soft - 2 * levels.noise, kInfinity);
    const auto denser = static_cast<float>(levels.denser());
    const double dense = std::max(mode_of(bright, 0.03 * (*levels.dense - levels.soft),
                                          [&](std::size_t i) { return depth.v[i] >= kInSkin && bright.v[i] > denser; })
                                      .value_or(*levels.dense),
                                  levels.denser());
    const double span = dense - levels.soft, half = levels.fixed_dense ? levels.denser() : levels.soft + 0.5 * span;
    // The blur makes a thin layer of the denser tissue darker. In such a layer the threshold is halfway between the
    // softer tissue and the brightest sample nearby, if this sample is clearly brighter than the softer tissue.
    const Sparse<float> peak = ball_max(
        bright, 2, where(set, false, false, [&](std::size_t i, const glm::ivec3&) { return depth.v[i] == kInSkin; }));
    const double faintest =
        levels.fixed_dense ? kInfinity : levels.soft + std::max(0.3 * span, 8 * levels.smoothed_noise);
    s.dense = std::move(bright);
    s.dense.outside = s.dense.inside = -0.5F;
    for_each_sample(*set, [&](const glm::ivec3&, std::size_t i) {
      const auto here = static_cast<double>(s.dense.v[i]);
      s.dense.v[i] = -0.5F;
      if (depth.v[i] < kInSkin) return;
      double bound = half;
      if (depth.v[i] == kInSkin && peak.v[i] > static_cast<float>(faintest))
        bound = std::min(half, 0.5 * (levels.soft + static_cast<double>(peak.v[i])));
      s.dense.v[i] = static_cast<float>(std::clamp((here - bound) / span, -0.5, 0.5));
    });
    // Removes isolated regions of the denser tissue (enamel or cortical bone) that are small compared with the largest
    // region, because they are noise. In a tooth, this limit is 5 % of the largest region, because enamel exists only
    // on the crown; otherwise it is 0.01 %.
    const SparseComponents parts = components(where(set, false, false, [&](std::size_t i, const glm::ivec3&) {
      return depth.v[i] >= kInSkin && s.dense.v[i] > 0;
    }));
    const auto keep = keep_large(parts, tooth ? 0.05 : 1e-4);
    for (std::size_t i = 0; i < parts.label.v.size(); ++i) {
      const auto id = static_cast<std::size_t>(parts.label.v[i]);
      if (id > 0 && !keep[id]) s.dense.v[i] = -0.1F;
    }
  }

  // Finds the cavities. In a tooth, these include thin canals that the blur has made brighter. A sample of such a canal
  // lies deeper than the outer edge. It is darker than halfway between dentin and the darkest grey value nearby, and
  // this darkest value must be clearly darker than dentin.
  s.cavity = limited(-kInfinity, levels.soft + 2 * levels.noise);
  const double drop = levels.soft - cavity_grey;
  constexpr float kNothing = 1e30F;
  Sparse<float> deep(set, kNothing, kNothing);
  for_each_sample(*set, [&](const glm::ivec3&, std::size_t i) {
    if (depth.v[i] == kBelowShell || (cavity.v[i] && depth.v[i] >= kInSkin)) deep.v[i] = s.cavity.v[i];
  });
  const Sparse<float> darkest =
      tooth ? ball_min(deep, std::clamp(2 * edge, 2.0, 5.0),
                       where(set, false, false, [&](std::size_t i, const glm::ivec3&) { return deep.v[i] < kNothing; }))
            : Sparse<float>();
  // smallest contrast between a canal and dentin
  const double least = std::max(0.25 * drop, 8 * levels.smoothed_noise);
  SparseMask pulp(set, 0, 1);
  s.cavity.outside = -0.5F, s.cavity.inside = 0.5F;
  for_each_sample(*set, [&](const glm::ivec3&, std::size_t i) {
    s.cavity.v[i] = -0.5F;
    if (!(deep.v[i] < kNothing)) return;
    double bound = levels.soft - 0.5 * drop;
    if (tooth && darkest.v[i] < static_cast<float>(levels.soft - least))
      bound = 0.5 * (levels.soft + std::max<double>(darkest.v[i], cavity_grey));
    const double here = (bound - static_cast<double>(deep.v[i])) / drop;
    s.cavity.v[i] = static_cast<float>(std::clamp(here, -0.5, 0.5));
    if (!tooth && !cavity.v[i]) s.cavity.v[i] = -0.5F;
    pulp.v[i] = s.cavity.v[i] > 0;
  });
  {
    const SparseComponents parts = components(pulp, true);
    std::vector<Contacts> faces(parts.voxels.size());
    for (std::size_t i = 0; i < pulp.v.size(); ++i) {
      const auto id = static_cast<std::size_t>(parts.label.v[i]);
      if (id == 0) continue;
      for (const glm::ivec3& f : kFaces) {
        const glm::ivec3 q = pulp.place(i) + f;
        if (!pulp.holds(q) || pulp[q]) continue;
        ++faces[id].wall;
        faces[id].dense += s.dense[q] > 0;
      }
    }
    std::vector<bool> keep(parts.voxels.size(), false);
    for (std::size_t k = 1; k < keep.size(); ++k) {
      keep[k] = parts.voxels[k] >= 40 && (!tooth || 2 * faces[k].dense < faces[k].wall);
      s.cavity_parts += keep[k] ? 1 : 0;
    }
    for (std::size_t i = 0; i < pulp.v.size(); ++i) {
      const auto id = static_cast<std::size_t>(parts.label.v[i]);
      if (id > 0 && !keep[id]) s.cavity.v[i] = -0.1F, pulp.v[i] = 0;
    }
  }

  // Moves the borders of enamel and pulp, because blur and partial volume change the grey values in thin layers.
  if (tooth) {
    const SparseMask enamel =
        where(set, false, false, [&](std::size_t i, const glm::ivec3&) { return s.dense.v[i] > 0 && !pulp.v[i]; });
    match_tooth_volumes(grey, s, enamel, pulp, levels, enamel_grey, cavity_grey, surround);
    for_each_sample(*set, [&](const glm::ivec3&, std::size_t i) { pulp.v[i] = s.cavity.v[i] > 0; });
  }

  // Isolated parts of the softer tissue are dark spots in enamel, or fissures that the blur has made brighter. They get
  // the label of the tissue around them.
  if (levels.dense && tooth) {
    const SparseMask soft = where(set, false, false, [&](std::size_t i, const glm::ivec3&) {
      return depth.v[i] >= kInSkin && !(s.dense.v[i] > 0) && !pulp.v[i];
    });
    const SparseComponents parts = components(soft);
    const auto keep = keep_large(parts, 0.02);
    std::vector<Contacts> faces(parts.voxels.size());
    for (std::size_t i = 0; i < soft.v.size(); ++i) {
      const auto id = static_cast<std::size_t>(parts.label.v[i]);
      if (id == 0 || keep[id]) continue;
      for (const glm::ivec3& f : kFaces) {
        const glm::ivec3 q = soft.place(i) + f;
        if (!soft.holds(q)) continue;
        faces[id].dense += s.dense[q] > 0;
        faces[id].cavity += pulp[q];
      }
    }
    for (std::size_t i = 0; i < soft.v.size(); ++i) {
      const auto id = static_cast<std::size_t>(parts.label.v[i]);
      if (id == 0 || keep[id]) continue;
      if (faces[id].dense > faces[id].cavity) s.dense.v[i] = 0.1F;
      if (faces[id].cavity > faces[id].dense) s.cavity.v[i] = 0.1F;
    }
  }

  // Samples just outside the surface get the label of the nearest tissue, because labels are interpolated at the
  // surface. The labels are copied from samples inside, which do not change any more.
  for_each_sample(*set, [&](const glm::ivec3& p, std::size_t i) {
    if (depth.v[i] != kNear) return;
    const glm::dvec3 n = normal_at(s.surface, p), on = glm::dvec3(s.surface.closest[p]);
    for (const double below : {0.75, 1.5, 2.25}) {
      const glm::ivec3 near = glm::clamp(glm::ivec3(glm::round(on - below * n)), glm::ivec3(0), size - 1);
      if (depth[near] < kInSkin) continue;
      s.dense.v[i] = s.dense[near];
      s.cavity.v[i] = s.cavity[near];
      break;
    }
  });
  s.grey = std::move(filled);
  report(1);
  return s;
}

}  // namespace typodont::haptics::importing
