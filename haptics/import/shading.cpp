#include "haptics/import/shading.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "engine/base/measure.h"

namespace typodont::haptics::importing {

namespace {

constexpr std::size_t kUnknowns = Shading::kTerms - 1;  // the gradient does not determine the constant term
using Unknowns = std::array<double, kUnknowns>;

/// A cell of the scan that has enough samples in uniform regions (with a small gradient of the grey value).
struct Cell {
  glm::dvec3 at;     // mean position, -1 … 1 over the scan
  glm::dvec3 slope;  // median gradient, per voxel
  double samples;
};

double power(double x, int exponent) {
  double product = 1;
  for (int k = 0; k < exponent; ++k) product *= x;
  return product;
}

double value(const Shading& s, const glm::dvec3& p) {
  double sum = 0;
  for (std::size_t t = 0; t < Shading::kTerms; ++t) {
    const glm::ivec3 e = Shading::powers()[t];
    sum += s.coefficient[t] * power(p.x, e.x) * power(p.y, e.y) * power(p.z, e.z);
  }
  return sum;
}

/// Finds the uniform cells: their samples have a gradient below `steepest`, and below 2 `steepest` two voxels away.
std::vector<Cell> uniform_cells(const Grid<float>& g, const glm::dvec3& spacing, double steepest) {
  // Edge of a cell, m; largest number of cells and of examined samples per axis; step of finite differences, voxels.
  constexpr double kCell = 2.4e-3;
  constexpr int kMaxCells = 24, kSamples = 8, kReach = 2;
  constexpr std::size_t kMin = 20;  // a cell with fewer uniform samples is dropped
  const glm::ivec3 edge =
      glm::max(glm::ivec3(glm::round(kCell / spacing)), glm::max(glm::ivec3(4), (g.size + kMaxCells - 1) / kMaxCells));
  const glm::ivec3 step = (edge + kSamples - 1) / kSamples, cells = (g.size + edge - 1) / edge;
  const float darkest = *std::min_element(g.v.begin(), g.v.end());
  const auto slope = [&](const glm::ivec3& p) {
    glm::dvec3 d;
    for (int a = 0; a < 3; ++a) {
      glm::ivec3 lo = p, hi = p;
      lo[a] -= kReach, hi[a] += kReach;
      d[a] = (static_cast<double>(g[hi]) - static_cast<double>(g[lo])) / (2 * kReach);
    }
    return d;
  };
  const auto steep = [&](const glm::ivec3& p) {
    for (int a = 0; a < 3; ++a) {
      for (const int away : {-kReach, kReach}) {
        glm::ivec3 q = p;
        q[a] += away;
        const glm::dvec3 d = slope(q);
        if (glm::dot(d, d) > 4 * steepest * steepest) return true;
      }
    }
    return false;
  };
  std::vector<std::vector<Cell>> of_slab(static_cast<std::size_t>(cells.x));
  for_each_in_parallel(cells.x, [&](int cx) {
    std::vector<double> slopes[3];
    for (int cy = 0; cy < cells.y; ++cy) {
      for (int cz = 0; cz < cells.z; ++cz) {
        const glm::ivec3 from = glm::max(glm::ivec3(cx, cy, cz) * edge, glm::ivec3(2 * kReach)),
                         to = glm::min(glm::ivec3(cx + 1, cy + 1, cz + 1) * edge, g.size - 2 * kReach);
        for (auto& of_axis : slopes) of_axis.clear();
        glm::dvec3 sum(0);
        glm::ivec3 p;
        for (p.x = from.x; p.x < to.x; p.x += step.x) {
          for (p.y = from.y; p.y < to.y; p.y += step.y) {
            for (p.z = from.z; p.z < to.z; p.z += step.z) {
              const glm::dvec3 d = slope(p);
              // A zero gradient comes from clipped or filled regions.
              if (d == glm::dvec3(0) || !(glm::dot(d, d) < steepest * steepest) || g[p] <= darkest || steep(p))
                continue;
              for (int a = 0; a < 3; ++a) slopes[a].push_back(d[a]);
              sum += glm::dvec3(p);
            }
          }
        }
        const std::size_t n = slopes[0].size();
        if (n < kMin) continue;
        of_slab[static_cast<std::size_t>(cx)].push_back(
            {2.0 * sum / (static_cast<double>(n) * glm::dvec3(g.size - 1)) - 1.0,
             {quantile(slopes[0], 0.5), quantile(slopes[1], 0.5), quantile(slopes[2], 0.5)},
             static_cast<double>(n)});
      }
    }
  });
  std::vector<Cell> all;
  for (const auto& slab : of_slab) all.insert(all.end(), slab.begin(), slab.end());
  return all;
}

/// Solves a symmetric positive definite system.
Unknowns solved(std::array<Unknowns, kUnknowns> a, Unknowns b) {
  for (std::size_t i = 0; i < kUnknowns; ++i) {
    for (std::size_t j = i + 1; j < kUnknowns; ++j) {
      const double factor = a[j][i] / a[i][i];
      for (std::size_t k = i; k < kUnknowns; ++k) a[j][k] -= factor * a[i][k];
      b[j] -= factor * b[i];
    }
  }
  for (std::size_t i = kUnknowns; i-- > 0;) {
    for (std::size_t k = i + 1; k < kUnknowns; ++k) b[i] -= a[i][k] * b[k];
    b[i] /= a[i][i];
  }
  return b;
}

/// Iteratively reweighted least squares with Cauchy weights.
Unknowns fitted(const std::vector<Cell>& cells, const glm::dvec3& voxels) {
  constexpr int kRounds = 8;
  // Residual of a cell, in σ, at which its weight is one half; lower limit of σ, grey values per voxel; regularization.
  constexpr double kLimit = 1.5, kMinSpread = 0.3, kRegular = 1e-9;
  struct Row {
    Unknowns of;
    double slope, samples, weight;
  };
  std::vector<Row> rows;
  rows.reserve(3 * cells.size());
  for (const Cell& c : cells) {
    for (int a = 0; a < 3; ++a) {
      Row row{.of = {}, .slope = c.slope[a], .samples = c.samples, .weight = c.samples};
      for (std::size_t t = 0; t < kUnknowns; ++t) {
        glm::ivec3 e = Shading::powers()[t + 1];
        // Derivative per voxel along axis a; the coordinate in the polynomial runs from -1 to 1 over the scan.
        const double factor = e[a] / (0.5 * voxels[a]);
        if (e[a] == 0) continue;
        --e[a];
        row.of[t] = factor * power(c.at.x, e.x) * power(c.at.y, e.y) * power(c.at.z, e.z);
      }
      rows.push_back(row);
    }
  }
  Unknowns x{};
  std::vector<double> residuals(rows.size());
  for (int round = 0; round < kRounds; ++round) {
    std::array<Unknowns, kUnknowns> normal{};
    Unknowns right{};
    for (const Row& row : rows) {
      for (std::size_t i = 0; i < kUnknowns; ++i) {
        const double w = row.weight * row.of[i];
        if (w == 0) continue;
        for (std::size_t j = 0; j < kUnknowns; ++j) normal[i][j] += w * row.of[j];
        right[i] += w * row.slope;
      }
    }
    double trace = 0;
    for (std::size_t i = 0; i < kUnknowns; ++i) trace += normal[i][i];
    for (std::size_t i = 0; i < kUnknowns; ++i) normal[i][i] += kRegular * trace / kUnknowns;
    x = solved(normal, right);
    for (std::size_t r = 0; r < rows.size(); ++r)
      residuals[r] = std::abs(rows[r].slope - std::inner_product(x.begin(), x.end(), rows[r].of.begin(), 0.0));
    const double spread = std::max(1.4826 * quantile(residuals, 0.5), kMinSpread);
    for (std::size_t r = 0; r < rows.size(); ++r)
      rows[r].weight = rows[r].samples / (1 + std::pow(residuals[r] / (kLimit * spread), 2));
  }
  return x;
}

}  // namespace

const std::array<glm::ivec3, Shading::kTerms>& Shading::powers() {
  static const std::array<glm::ivec3, kTerms> all = [] {
    std::array<glm::ivec3, kTerms> exponents;
    std::size_t t = 0;
    for (int x = 0; x <= kDegree; ++x) {
      for (int y = 0; x + y <= kDegree; ++y) {
        for (int z = 0; x + y + z <= kDegree; ++z) exponents[t++] = {x, y, z};
      }
    }
    return exponents;
  }();
  return all;
}

void Shading::remove_from(Scan& scan) const {
  Grid<float>& g = scan.grey;
  const glm::dvec3 first = (scan.origin - centre) / half, step = scan.spacing / half;
  for_each_in_parallel(g.size.x, [&](int x) {
    for (int y = 0; y < g.size.y; ++y) {
      const double px = first.x + x * step.x, py = first.y + y * step.y;
      std::array<double, kDegree + 1> of_z{};  // coefficients of the polynomial in z along this row
      for (std::size_t t = 0; t < kTerms; ++t) {
        const glm::ivec3 e = powers()[t];
        of_z[static_cast<std::size_t>(e.z)] += coefficient[t] * power(px, e.x) * power(py, e.y);
      }
      float* row = &g(x, y, 0);
      for (int z = 0; z < g.size.z; ++z) {
        const double pz = first.z + z * step.z;
        double sum = 0;
        for (std::size_t k = of_z.size(); k-- > 0;) sum = sum * pz + of_z[k];
        row[z] -= static_cast<float>(sum);
      }
    }
  });
}

std::optional<Shading> find_shading(const Scan& scan, const Grid<float>& smooth, double noise) {
  // kMinRange: a smaller shading is not removed. kSteepest, kPerNoise: largest gradient of uniform tissue, per voxel
  // and relative to noise. kOuter: where the outer part begins, as a fraction of half the extent. kDarkest: the
  // shading's range ignores this fraction of the cells at its lower end, and the same fraction at its upper end.
  constexpr double kMinRange = 100, kSteepest = 40, kPerNoise = 0.6, kOuter = 0.7, kDarkest = 0.02;
  constexpr std::size_t kMinCells = 100;
  const std::vector<Cell> cells = uniform_cells(smooth, scan.spacing, std::max(kSteepest, kPerNoise * noise));
  if (cells.size() < kMinCells) return std::nullopt;
  Shading s;
  s.half = 0.5 * glm::dvec3(scan.grey.size - 1) * scan.spacing;
  s.centre = scan.origin + s.half;
  const Unknowns x = fitted(cells, glm::dvec3(scan.grey.size - 1));
  std::ranges::copy(x, s.coefficient.begin() + 1);
  std::vector<double> all, outer;
  for (const Cell& c : cells) {
    all.push_back(value(s, c.at));
    if (glm::any(glm::greaterThan(glm::abs(c.at), glm::dvec3(kOuter)))) outer.push_back(all.back());
  }
  std::ranges::sort(all);
  const auto at = [&](double fraction) {
    return all[static_cast<std::size_t>(fraction * static_cast<double>(all.size() - 1))];
  };
  s.range = at(1 - kDarkest) - at(kDarkest);
  if (!(s.range >= kMinRange)) return std::nullopt;
  s.coefficient[0] = outer.empty() ? -at(0.5) : -quantile(outer, 0.5);
  return s;
}

}  // namespace typodont::haptics::importing
