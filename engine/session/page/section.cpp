#include "engine/session/page/section.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "engine/session/page/plot.h"

namespace typodont::session {

namespace {

constexpr double kAround = 1.2e-3;  // m, margin around the changed region

struct Window {
  // Bounds of the drawn part of the section's plane, m, relative to the point `through`.
  double x0 = 0, x1 = 0, y0 = 0, y1 = 0;
};

/// Curves value(x, y) = 0 by marching squares, as an SVG path in drawing units.
std::string contour(const Window& w, double step, double scale, const std::function<double(double, double)>& value) {
  std::string path;
  const int nx = static_cast<int>((w.x1 - w.x0) / step), ny = static_cast<int>((w.y1 - w.y0) / step);
  std::vector<double> row(static_cast<std::size_t>(nx) + 1), next(row.size());
  const auto fill = [&](std::vector<double>& to, int j) {
    for (int i = 0; i <= nx; ++i) to[static_cast<std::size_t>(i)] = value(w.x0 + i * step, w.y0 + j * step);
  };
  fill(next, 0);
  for (int j = 0; j < ny; ++j) {
    std::swap(row, next);
    fill(next, j + 1);
    for (int i = 0; i < nx; ++i) {
      const auto k = static_cast<std::size_t>(i);
      // Results of value(x, y) at the corners of the cell.
      const double v[4] = {row[k], row[k + 1], next[k + 1], next[k]};
      const glm::dvec2 corner[4] = {{i, j}, {i + 1, j}, {i + 1, j + 1}, {i, j + 1}};
      glm::dvec2 cross[4];
      int count = 0;
      for (int e = 0; e < 4; ++e) {
        const int f = (e + 1) % 4;
        if ((v[e] < 0) == (v[f] < 0)) continue;
        cross[count++] = corner[e] + v[e] / (v[e] - v[f]) * (corner[f] - corner[e]);
      }
      for (int e = 0; e + 1 < count; e += 2) {
        const auto x = [&](const glm::dvec2& p) { return p.x * step * scale; };
        const auto y = [&](const glm::dvec2& p) { return (w.y1 - w.y0 - p.y * step) * scale; };
        path += fmt::format("M{:.1f} {:.1f}L{:.1f} {:.1f}", x(cross[e]), y(cross[e]), x(cross[e + 1]), y(cross[e + 1]));
      }
    }
  }
  return path;
}

}  // namespace

std::string section_svg(const Preparation& in, const dvec3& through_W, const dvec3& along_W, const std::string& label,
                        const SectionSides& sides) {
  const dvec3 up = glm::normalize(in.axis_W);
  const dvec3 along = glm::normalize(along_W - glm::dot(along_W, up) * up);
  const auto at = [&](double x, double y) { return in.frame.to_voxels(through_W + x * along + y * up); };
  const auto inside_box = [&](const dvec3& p) {
    return !glm::any(glm::lessThan(p, dvec3(0))) && !glm::any(glm::greaterThan(p, dvec3(in.before.size - 1)));
  };
  // The window contains all differences between before, after and ideal.
  const double step = 0.5 * in.frame.voxel, reach = glm::length(dvec3(in.before.size)) * in.frame.voxel;
  Window w{1e9, -1e9, 1e9, -1e9};
  for (double x = -reach; x <= reach; x += 2 * step) {
    for (double y = -reach; y <= reach; y += 2 * step) {
      const dvec3 p = at(x, y);
      if (!inside_box(p)) continue;
      const double b = in.before.sample(p), a = in.after.sample(p);
      const double c = in.ideal.distance.empty() ? b : in.ideal.sample(p);
      if ((b < 0) == (a < 0) && (b < 0) == (c < 0)) continue;
      w = {std::min(w.x0, x), std::max(w.x1, x), std::min(w.y0, y), std::max(w.y1, y)};
    }
  }
  if (w.x0 > w.x1) return "";
  w = {w.x0 - kAround, w.x1 + kAround, w.y0 - kAround, w.y1 + kAround};
  const double scale = 400 / (w.x1 - w.x0);  // number of drawing units per metre
  const double height = (w.y1 - w.y0) * scale;
  const auto curve = [&](const DenseField& field, const char* css) {
    if (field.distance.empty()) return std::string();
    const std::string path = contour(w, step, scale, [&](double x, double y) { return field.sample(at(x, y)); });
    return path.empty() ? std::string() : fmt::format("<path class=\"{}\" d=\"{}\"/>", css, path);
  };
  return fmt::format(
      "<svg class=\"section\" viewBox=\"0 0 400 {:.0f}\" role=\"img\" aria-label=\"{}\">{}{}{}"
      "<path class=\"ruler\" d=\"M12 {:.1f}h{:.1f}\"/><text x=\"12\" y=\"{:.1f}\">1 mm</text>"
      "<text x=\"6\" y=\"14\">{}</text><text x=\"394\" y=\"14\" text-anchor=\"end\">{}</text></svg>",
      height, escaped(label), curve(in.before, "was"), curve(in.ideal, "ideal"), curve(in.after, "is"), height - 10,
      1e-3 * scale, height - 15, escaped(sides.left), escaped(sides.right));
}

}  // namespace typodont::session
