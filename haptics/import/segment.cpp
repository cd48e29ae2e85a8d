#include "haptics/import/segment.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace typodont::haptics::importing {

namespace {

constexpr double kStep = 0.5;  // voxels, along rays

const std::array<glm::ivec3, 6> kFaces = {glm::ivec3(1, 0, 0), {-1, 0, 0}, {0, 1, 0},
                                          {0, -1, 0},          {0, 0, 1},  {0, 0, -1}};

// Faces of a part's voxels, by what lies on the other side.
struct Contacts {
  std::size_t mouth = 0, wall = 0, dense = 0, cavity = 0;
};

Mask where(const Grid<float>& g, float above) {
  Mask mask(g.size, 0);
  for (std::size_t i = 0; i < g.v.size(); ++i) mask.v[i] = g.v[i] > above;
  return mask;
}

Mask where_below(const Grid<float>& g, float bound) {
  Mask mask(g.size, 0);
  for (std::size_t i = 0; i < g.v.size(); ++i) mask.v[i] = g.v[i] < bound;
  return mask;
}

// Voxels of `open` that hang together with the walls of the box.
Mask reached_from_walls(const Mask& open) {
  Mask reached(open.size, 0);
  std::vector<glm::ivec3> stack;
  const auto visit = [&](const glm::ivec3& p) {
    if (open[p] && !reached[p]) reached[p] = 1, stack.push_back(p);
  };
  for (int x = 0; x < open.size.x; ++x) {
    for (int y = 0; y < open.size.y; ++y) {
      for (int z = 0; z < open.size.z; ++z) {
        if (x == 0 || y == 0 || z == 0 || x == open.size.x - 1 || y == open.size.y - 1 || z == open.size.z - 1)
          visit({x, y, z});
      }
    }
  }
  while (!stack.empty()) {
    const glm::ivec3 p = stack.back();
    stack.pop_back();
    for (const glm::ivec3& f : kFaces) {
      if (open.holds(p + f)) visit(p + f);
    }
  }
  return reached;
}

// The cavities of the solid: what the surround cannot reach, or only through a narrow mouth. A ball that grows from
// nothing to the widest mouth rolls in from the walls; a pocket it cannot enter is a cavity when its mouth is a small
// part of its wall (a root canal), and stays outside when not (a fissure, the gap between two roots).
Mask find_cavities(const Mask& solid, const Mask& dense, double widest_mouth, bool tooth) {
  Mask open(solid.size, 0);
  for (std::size_t i = 0; i < open.v.size(); ++i) open.v[i] = !solid.v[i];
  const Mask outside = reached_from_walls(open);
  Mask cavity(solid.size, 0);
  for (std::size_t i = 0; i < open.v.size(); ++i) cavity.v[i] = open.v[i] && !outside.v[i];

  const Grid<float> clearance = distance_squared_to(solid);
  for (double r = 1; r <= widest_mouth; r += 0.5) {
    Mask roomy(solid.size, 0);
    for (std::size_t i = 0; i < roomy.v.size(); ++i) {
      roomy.v[i] = open.v[i] && !cavity.v[i] && clearance.v[i] > static_cast<float>(r * r);
    }
    const Mask centres = reached_from_walls(roomy);
    const Grid<float> from_centre = distance_squared_to(centres);
    Mask pocket(solid.size, 0);
    bool any = false;
    for (std::size_t i = 0; i < pocket.v.size(); ++i) {
      pocket.v[i] = outside.v[i] && !cavity.v[i] && from_centre.v[i] > static_cast<float>((r + 1) * (r + 1));
      any = any || pocket.v[i];
    }
    if (!any) continue;
    const Components parts = components(pocket);
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
      const bool plug = 2 * f.cavity > f.mouth;  // the rest of a mouth that a smaller ball dipped into
      if ((narrow || plug) && !(tooth && 2 * f.dense > f.wall + f.cavity)) cavity.v[i] = 1;
    }
  }
  return cavity;
}

// Removes all but the largest part (or, with a share below one, all parts smaller than that share of it).
std::vector<bool> keep_large(const Components& parts, double share) {
  std::vector<bool> keep(parts.voxels.size(), false);
  const std::int32_t largest = parts.largest();
  if (largest == 0) return keep;
  for (std::size_t k = 1; k < keep.size(); ++k) {
    keep[k] = static_cast<double>(parts.voxels[k]) >=
              share * static_cast<double>(parts.voxels[static_cast<std::size_t>(largest)]);
  }
  if (share >= 1) {
    std::fill(keep.begin(), keep.end(), false);
    keep[static_cast<std::size_t>(largest)] = true;
  }
  return keep;
}

// The grey with most voxels; nothing when there are hardly any.
std::optional<double> mode_of(std::vector<float> values, double width) {
  if (values.size() < 50) return std::nullopt;
  std::sort(values.begin(), values.end());
  std::size_t best = 0, lo = 0;
  double mode = values.back();
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

// Outward normal at sample i: away from its closest point, or the field's slope where it lies on the surface.
glm::dvec3 normal_at(const DistanceField& d, const glm::ivec3& i) {
  const glm::ivec3 hi = d.distance.size - 1;
  glm::dvec3 slope;
  for (int a = 0; a < 3; ++a) {
    glm::ivec3 p = i, m = i;
    p[a] = std::min(i[a] + 1, hi[a]);
    m[a] = std::max(i[a] - 1, 0);
    slope[a] = static_cast<double>(d.distance[p]) - static_cast<double>(d.distance[m]);
  }
  const double distance = d.distance[i];
  if (std::abs(distance) > 0.3) {
    const glm::dvec3 n =
        unit((glm::dvec3(i) - glm::dvec3(d.closest_to(d.distance.index(i)))) * (distance < 0 ? -1.0 : 1.0));
    if (glm::dot(n, n) > 0.5) return n;
  }
  return unit(slope);
}

}  // namespace

Segmentation segment(const Grid<float>& grey, const Levels& levels, double voxel, ImportPreset preset,
                     const std::function<void(double)>& progress) {
  const auto report = [&](double done) {
    if (progress) progress(done);
  };
  const bool tooth = preset == ImportPreset::kTooth;
  Segmentation s;
  const double rise = levels.soft - levels.outside;  // of the softer tissue over the surround
  const glm::ivec3 size = grey.size;
  const std::size_t count = grey.v.size();

  // Greys with less noise: one for masks, one that leaves curved edges in place for labels.
  const Grid<float> smooth = gaussian(grey, 0.8);
  report(0.1);

  // A first surface, at half the height of the brighter tissue where that is near, so that fissures in enamel stay
  // open; but safely below the softer tissue's own grey.
  const double most_height = std::max(0.8, levels.height);
  // Far below every threshold the brightest near by decides nothing.
  Grid<float> brightest = ball_max(smooth, 2, where(smooth, static_cast<float>(levels.surface() - 0.5 * rise)));
  Grid<float> over(size);  // smooth grey over the local threshold
  for (std::size_t i = 0; i < count; ++i) {
    const double top = std::clamp<double>(brightest.v[i], levels.soft, levels.top());
    const double threshold =
        std::min(levels.outside + levels.height * (top - levels.outside), levels.outside + most_height * rise);
    over.v[i] = static_cast<float>((smooth.v[i] - threshold) / rise);
  }
  brightest = Grid<float>();
  Mask solid = where(over, 0);
  {
    const Components parts = components(solid);
    const auto keep = keep_large(parts, 1);
    for (std::size_t i = 0; i < count; ++i) solid.v[i] = keep[static_cast<std::size_t>(parts.label.v[i])];
  }
  Mask dense_mask(size, 0);
  if (levels.dense) dense_mask = where(smooth, static_cast<float>(levels.denser()));
  const Mask cavity = find_cavities(solid, dense_mask, std::min(0.75e-3 / voxel, 8.0), tooth);
  for (std::size_t i = 0; i < count; ++i) {
    const bool filled = solid.v[i] || cavity.v[i];
    over.v[i] = std::clamp(over.v[i], -0.5F, 0.5F);
    if (cavity.v[i]) over.v[i] = 0.5F;
    if (!filled) over.v[i] = std::min(over.v[i], -0.01F);
  }
  report(0.25);

  constexpr double kFirstBand = 9;
  DistanceField first = signed_distance(over, size, {}, kFirstBand);
  over = Grid<float>();
  report(0.45);

  // How wide the scan's edges are: a Gaussian edge of height c has slope c / (σ √2π) in its middle.
  const auto inward_peak = [&](const glm::dvec3& from, const glm::dvec3& n, double depth) {
    float peak = sample(smooth, from);
    for (double t = kStep; t <= depth; t += kStep) peak = std::max(peak, sample(smooth, from - t * n));
    return static_cast<double>(peak);
  };
  std::vector<float> widths;
  for (std::size_t i = 0; i < count; i += 3) {
    if (std::abs(first.distance.v[i]) > 0.5) continue;
    const glm::ivec3 p = grey.place(i);
    const glm::dvec3 n = normal_at(first, p);
    const double top = std::clamp(inward_peak(glm::dvec3(p), n, 4), levels.soft, levels.top());
    const double slope = glm::length(sample_cubic(smooth, glm::dvec3(first.closest_to(i))).gradient);
    if (slope > 0) widths.push_back(static_cast<float>((top - levels.outside) / (std::sqrt(2 * M_PI) * slope)));
  }
  double edge = 1.2;  // voxels, of the smoothed greys
  if (!widths.empty()) {
    std::nth_element(widths.begin(), widths.begin() + static_cast<std::ptrdiff_t>(widths.size() / 2), widths.end());
    edge = std::clamp<double>(widths[widths.size() / 2], 0.8, 3);
  }
  s.blur = std::sqrt(std::max(0.0, edge * edge - 0.64));
  const double shell = std::clamp(2.5 * edge, 2.5, 6.0);  // voxels: how far an edge reaches to either side

  // The surround's grey near the surface: its mean over voxels beyond the edge's reach.
  Grid<float> sum(size, 0), weight(size, 0);
  for (std::size_t i = 0; i < count; ++i) {
    if (first.distance.v[i] < shell) continue;
    if (smooth.v[i] > levels.surface()) continue;  // other bodies
    sum.v[i] = static_cast<float>(grey.v[i] - levels.outside);
    weight.v[i] = 1;
  }
  sum = gaussian(sum, 4);
  weight = gaussian(weight, 4);
  const auto outside_near = [&](std::size_t i) {
    // A little of the global value, so that where hardly any surround is near (a fissure) it takes over smoothly.
    return levels.outside + sum.v[i] / (weight.v[i] + 0.02F);
  };
  report(0.55);

  // Occupancy: the grey on the scale from the surround to the tissue just below the surface. Behind the brightest point
  // of the way in from outside it stays one, so that dentin under enamel and pulp are as solid as any.
  Grid<float> occupancy(size, 0);
  for_each_slab(size.x, [&](int x) {
    for (int y = 0; y < size.y; ++y) {
      for (int z = 0; z < size.z; ++z) {
        const glm::ivec3 p(x, y, z);
        const std::size_t i = grey.index(p);
        const double d = first.distance.v[i];
        if (d >= shell) continue;
        if (d <= -shell) {
          occupancy.v[i] = 1;
          continue;
        }
        const glm::dvec3 n = normal_at(first, p);
        const glm::dvec3 at = glm::dvec3(first.closest_to(i));
        const double top = std::clamp(inward_peak(at, n, shell), levels.soft, levels.top());
        double low = outside_near(i);
        if (levels.fixed_surround) {
          // A thin layer of soft tissue on the bone is its surround, not the air behind it.
          double brightest_near = low;
          for (double t = 2 * edge; t <= shell; t += kStep)
            brightest_near = std::max<double>(brightest_near, sample(smooth, at + t * n));
          low = std::max(low, std::min(levels.outside, brightest_near));
        }
        const auto share = [&](double g) { return (g - low) / (top - low); };
        double o = share(grey.v[i]);
        if (d < 0) {
          for (double t = 1; t < -d + 1; t += kStep) o = std::max(o, share(sample(smooth, glm::dvec3(p) + t * n)));
          if (cavity.v[i]) o = 1;
        }
        occupancy.v[i] = static_cast<float>(std::clamp(o, 0.0, 1.0));
      }
    }
  });
  report(0.65);

  first = DistanceField();
  sum = weight = Grid<float>();

  // At least so much smoothing that edges are told by several samples, and until the noise moves the surface by less
  // than 0.02 voxel.
  double sigma = std::sqrt(std::max(1.1 * 1.1 - s.blur * s.blur, 0.7 * 0.7));
  for (; sigma < 2; sigma += 0.1) {
    const double left = levels.noise / rise * noise_left(sigma, s.blur);
    const double slope = 1 / (std::sqrt(2 * M_PI) * std::hypot(s.blur, sigma));
    if (left / slope < 0.02) break;
  }
  s.phi = smooth_in_place(occupancy, sigma, s.blur);
  occupancy = Grid<float>();
  for (float& v : s.phi.v) v -= static_cast<float>(levels.height);

  // One body, without holes that smoothing may have opened.
  {
    const Components parts = components(where(s.phi, 0));
    const auto keep = keep_large(parts, 1);
    for (std::size_t i = 0; i < count; ++i) {
      if (s.phi.v[i] > 0 && !keep[static_cast<std::size_t>(parts.label.v[i])]) s.phi.v[i] = -0.01F;
    }
    Mask open(size, 0);
    for (std::size_t i = 0; i < count; ++i) open.v[i] = !(s.phi.v[i] > 0);
    const Mask reached = reached_from_walls(open);
    for (std::size_t i = 0; i < count; ++i) {
      if (open.v[i] && !reached.v[i]) s.phi.v[i] = 0.01F;
    }
    s.bodies_kept = static_cast<int>(components(where(s.phi, 0)).voxels.size()) - 1;
  }
  const double surface_band = std::max(2 * shell, 6.0);
  const DistanceField surface = signed_distance(s.phi, size, {}, surface_band);
  const Grid<float>& d = surface.distance;
  report(0.85);

  // For the labels the outer edge is taken out of the greys: in the skin that it dims, and outside, stands the
  // brightest grey on the way further in. So enamel has no skin of false dentin, and dentin no skin of anything.
  const double skin = std::min(shell, 2 * edge + 0.5);
  Grid<float> filled = grey;
  for_each_slab(size.x, [&](int x) {
    for (int y = 0; y < size.y; ++y) {
      for (int z = 0; z < size.z; ++z) {
        const glm::ivec3 p(x, y, z);
        const std::size_t i = grey.index(p);
        if (d.v[i] < -skin) continue;
        if (d.v[i] >= surface_band) {
          filled.v[i] = static_cast<float>(levels.soft);
          continue;
        }
        const glm::dvec3 from = d.v[i] > 0 ? glm::dvec3(surface.closest_to(i)) : glm::dvec3(p);
        filled.v[i] = static_cast<float>(inward_peak(from, normal_at(surface, p), skin));
      }
    }
  });
  const auto limited = [&](double lo, double hi) {
    Grid<float> g = filled;
    for (float& v : g.v) v = std::clamp(v, static_cast<float>(lo), static_cast<float>(hi));
    return smooth_in_place(g, 0.8, s.blur);
  };
  constexpr double kInfinity = std::numeric_limits<float>::max();

  // Denser tissue: brighter than half way between the two.
  s.dense = Grid<float>(size, -0.5F);
  s.cavity = Grid<float>(size, -0.5F);
  if (levels.dense) {
    const Grid<float> bright = limited(levels.soft - 2 * levels.noise, kInfinity);
    std::vector<float> greys;
    for (std::size_t i = 0; i < count; ++i) {
      if (d.v[i] <= 0 && bright.v[i] > static_cast<float>(levels.denser())) greys.push_back(bright.v[i]);
    }
    const double dense = std::max(
        mode_of(std::move(greys), 0.03 * (*levels.dense - levels.soft)).value_or(*levels.dense), levels.denser());
    const double span = dense - levels.soft, half = levels.fixed_dense ? levels.denser() : levels.soft + 0.5 * span;
    // Where the layer thins out the blur takes its height: there half way to what is left of it, as long as that is
    // clearly brighter than the softer tissue.
    Mask skin_mask(size, 0);
    for (std::size_t i = 0; i < count; ++i) skin_mask.v[i] = d.v[i] <= 0 && d.v[i] > static_cast<float>(-skin);
    const Grid<float> peak = ball_max(bright, 2, skin_mask);
    const double faintest =
        levels.fixed_dense ? kInfinity : levels.soft + std::max(0.3 * span, 8 * levels.smoothed_noise);
    for (std::size_t i = 0; i < count; ++i) {
      if (d.v[i] > 0) continue;
      double bound = half;
      if (d.v[i] > -skin && peak.v[i] > faintest) bound = std::min(half, 0.5 * (levels.soft + peak.v[i]));
      s.dense.v[i] = static_cast<float>(std::clamp((bright.v[i] - bound) / span, -0.5, 0.5));
    }
    // Specks of the denser tissue are noise; on a tooth only the crown's cap is enamel.
    Mask mask(size, 0);
    for (std::size_t i = 0; i < count; ++i) mask.v[i] = d.v[i] <= 0 && s.dense.v[i] > 0;
    const Components parts = components(mask);
    const auto keep = keep_large(parts, tooth ? 0.05 : 1e-4);
    for (std::size_t i = 0; i < count; ++i) {
      if (mask.v[i] && !keep[static_cast<std::size_t>(parts.label.v[i])]) s.dense.v[i] = -0.1F;
    }
  }

  // Cavities. In a tooth also thin canals that the blur fills half: darker than half way between dentin and the darkest
  // grey near, where that is clearly darker than dentin, deeper than the outer edge reaches.
  const Grid<float> dark = limited(-kInfinity, levels.soft + 2 * levels.noise);
  double cavity_grey = levels.outside;
  {
    std::vector<float> greys, inner;
    Mask wall(size, 0);
    for (std::size_t i = 0; i < count; ++i) wall.v[i] = !cavity.v[i];
    const Grid<float> to_wall = distance_squared_to(wall);
    for (std::size_t i = 0; i < count; ++i) {
      if (cavity.v[i]) greys.push_back(smooth.v[i]);
      if (cavity.v[i] && to_wall.v[i] > static_cast<float>(4 * edge * edge)) inner.push_back(smooth.v[i]);
    }
    std::vector<float>& told = inner.size() >= 20 ? inner : greys;
    if (!told.empty()) {
      const auto k = static_cast<std::ptrdiff_t>(told.size() / (inner.size() >= 20 ? 2 : 10));
      std::nth_element(told.begin(), told.begin() + k, told.end());
      cavity_grey = told[static_cast<std::size_t>(k)];
    }
  }
  const double drop = levels.soft - cavity_grey;
  constexpr float kNothing = 1e30F;
  Grid<float> deep(size, kNothing);
  for (std::size_t i = 0; i < count; ++i) {
    if (d.v[i] < 0 && (cavity.v[i] || d.v[i] < -shell)) deep.v[i] = dark.v[i];
  }
  const Grid<float> darkest =
      tooth ? ball_min(deep, std::clamp(2 * edge, 2.0, 5.0), where_below(deep, kNothing)) : Grid<float>();
  const double least = std::max(0.25 * drop, 8 * levels.smoothed_noise);  // contrast of a canal
  Mask pulp(size, 0);
  for (std::size_t i = 0; i < count; ++i) {
    if (!(deep.v[i] < kNothing)) continue;
    double bound = levels.soft - 0.5 * drop;
    if (tooth && darkest.v[i] < levels.soft - least)
      bound = 0.5 * (levels.soft + std::max<double>(darkest.v[i], cavity_grey));
    const double here = (bound - dark.v[i]) / drop;
    s.cavity.v[i] = static_cast<float>(std::clamp(here, -0.5, 0.5));
    if (!tooth && !cavity.v[i]) s.cavity.v[i] = -0.5F;
    pulp.v[i] = s.cavity.v[i] > 0;
  }
  {
    const Components parts = components(pulp, true);
    std::vector<Contacts> faces(parts.voxels.size());
    for (std::size_t i = 0; i < count; ++i) {
      const auto id = static_cast<std::size_t>(parts.label.v[i]);
      if (id == 0) continue;
      for (const glm::ivec3& f : kFaces) {
        const glm::ivec3 q = grey.place(i) + f;
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
    for (std::size_t i = 0; i < count; ++i) {
      const auto id = static_cast<std::size_t>(parts.label.v[i]);
      if (pulp.v[i] && !keep[id]) s.cavity.v[i] = -0.1F, pulp.v[i] = 0;
    }
  }

  // Islands of the softer tissue, off its main body, belong to what surrounds them: dark spots in enamel, fissures half
  // filled by the blur.
  if (levels.dense && tooth) {
    Mask soft(size, 0);
    for (std::size_t i = 0; i < count; ++i) soft.v[i] = d.v[i] <= 0 && !(s.dense.v[i] > 0) && !pulp.v[i];
    const Components parts = components(soft);
    const auto keep = keep_large(parts, 0.02);
    std::vector<Contacts> faces(parts.voxels.size());
    for (std::size_t i = 0; i < count; ++i) {
      const auto id = static_cast<std::size_t>(parts.label.v[i]);
      if (id == 0 || keep[id]) continue;
      for (const glm::ivec3& f : kFaces) {
        const glm::ivec3 q = grey.place(i) + f;
        if (!soft.holds(q)) continue;
        faces[id].dense += s.dense[q] > 0;
        faces[id].cavity += pulp[q];
      }
    }
    for (std::size_t i = 0; i < count; ++i) {
      const auto id = static_cast<std::size_t>(parts.label.v[i]);
      if (id == 0 || keep[id]) continue;
      if (faces[id].dense > faces[id].cavity) s.dense.v[i] = 0.1F;
      if (faces[id].cavity > faces[id].dense) s.cavity.v[i] = 0.1F;
    }
  }

  // Outside the surface the labels of the nearest tissue, so that they can be read and interpolated at the surface.
  const Grid<float> dense_inside = s.dense, cavity_inside = s.cavity;
  for_each_slab(size.x, [&](int x) {
    for (int y = 0; y < size.y; ++y) {
      for (int z = 0; z < size.z; ++z) {
        const std::size_t i = grey.index(x, y, z);
        if (!(d.v[i] > 0) || d.v[i] > 3) continue;
        const glm::ivec3 p(x, y, z);
        const glm::dvec3 c = glm::dvec3(surface.closest_to(i)) - 0.75 * normal_at(surface, p);
        const glm::ivec3 near = glm::clamp(glm::ivec3(glm::round(c)), glm::ivec3(0), size - 1);
        s.dense.v[i] = dense_inside[near];
        s.cavity.v[i] = cavity_inside[near];
      }
    }
  });
  s.grey = std::move(filled);
  report(1);
  return s;
}

}  // namespace typodont::haptics::importing
