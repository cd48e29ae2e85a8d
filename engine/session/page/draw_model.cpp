#include <png.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/session/page/model_colors.h"
#include "engine/session/result_model.h"

namespace typodont::session {

namespace {

constexpr int kFine = 2;  // number of samples per pixel, along each axis

std::vector<std::uint8_t> png_of(const std::vector<std::uint8_t>& rgb, glm::ivec2 size) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(size.x);
  image.height = static_cast<png_uint_32>(size.y);
  image.format = PNG_FORMAT_RGB;
  png_alloc_size_t bytes = PNG_IMAGE_PNG_SIZE_MAX(image);
  std::vector<std::uint8_t> out(bytes);
  if (!png_image_write_to_memory(&image, out.data(), &bytes, 0, rgb.data(), 0, nullptr)) return {};
  out.resize(bytes);
  return out;
}

}  // namespace

ModelView angled_view(const dvec3& axis_W) {
  const dvec3 other = std::abs(axis_W.x) < 0.7 ? dvec3(1, 0, 0) : dvec3(0, 0, 1);
  const dvec3 right = glm::normalize(other - glm::dot(other, axis_W) * axis_W), away = glm::cross(axis_W, right);
  return {glm::normalize(-0.75 * axis_W + 0.6 * away - 0.3 * right), axis_W};
}

std::vector<std::uint8_t> draw_model(const ResultModel& model, const ModelView& view, glm::ivec2 pixels,
                                     bool difference) {
  return png_of(draw_model_pixels(model, view, pixels, difference, glm::vec3(255)), pixels);
}

std::vector<std::uint8_t> draw_model_pixels(const ResultModel& model, const ModelView& view, glm::ivec2 pixels,
                                            bool difference, const glm::vec3& ground) {
  const dvec3 back = -glm::normalize(view.look_W);
  const dvec3 right = glm::normalize(glm::cross(view.up_W, back)), up = glm::cross(back, right);
  struct Point {
    float x, y, z;
    glm::vec3 color;
  };
  glm::vec2 lo(1e9f), hi(-1e9f);
  std::vector<Point> points;
  points.reserve(model.vertices.size());
  const glm::vec3 light(glm::normalize(back + 0.5 * up - 0.4 * right));
  for (const ResultModel::Vertex& v : model.vertices) {
    const dvec3 p(v.p_W);
    glm::vec3 color = difference ? difference_color(v.off / static_cast<float>(kFullColor)) : glm::vec3(0);
    if (!difference) {
      const auto& c = kTissueColors[static_cast<std::size_t>(v.tissue)];
      color = glm::vec3(static_cast<float>(c[0]), static_cast<float>(c[1]), static_cast<float>(c[2]));
    }
    color *= 0.42f + 0.58f * std::max(0.0f, glm::dot(v.n, light));
    points.push_back({static_cast<float>(glm::dot(p, right)), static_cast<float>(glm::dot(p, up)),
                      static_cast<float>(glm::dot(p, back)), color});
    lo = glm::min(lo, glm::vec2(points.back().x, points.back().y));
    hi = glm::max(hi, glm::vec2(points.back().x, points.back().y));
  }
  const glm::ivec2 fine = pixels * kFine;
  const glm::vec2 extent = glm::max(hi - lo, glm::vec2(1e-6f));
  const float scale = 0.94f * std::min(static_cast<float>(fine.x) / extent.x, static_cast<float>(fine.y) / extent.y);
  const glm::vec2 middle = 0.5f * (lo + hi);
  for (Point& p : points) {
    p.x = 0.5f * static_cast<float>(fine.x) + scale * (p.x - middle.x);
    p.y = 0.5f * static_cast<float>(fine.y) - scale * (p.y - middle.y);
  }

  std::vector<float> depth(static_cast<std::size_t>(fine.x) * static_cast<std::size_t>(fine.y),
                           -std::numeric_limits<float>::infinity());
  std::vector<glm::vec3> color(depth.size(), ground);
  for (const auto& triangle : model.triangles) {
    const Point &a = points[triangle[0]], &b = points[triangle[1]], &c = points[triangle[2]];
    const float area = (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y);
    if (!(area < 0)) continue;  // the triangle is seen from behind (the picture's y points down)
    const int x0 = std::max(0, static_cast<int>(std::floor(std::min({a.x, b.x, c.x}))));
    const int x1 = std::min(fine.x - 1, static_cast<int>(std::ceil(std::max({a.x, b.x, c.x}))));
    const int y0 = std::max(0, static_cast<int>(std::floor(std::min({a.y, b.y, c.y}))));
    const int y1 = std::min(fine.y - 1, static_cast<int>(std::ceil(std::max({a.y, b.y, c.y}))));
    for (int y = y0; y <= y1; ++y) {
      for (int x = x0; x <= x1; ++x) {
        const float px = static_cast<float>(x) + 0.5f, py = static_cast<float>(y) + 0.5f;
        const float u = ((b.x - px) * (c.y - py) - (c.x - px) * (b.y - py)) / area;
        const float v = ((c.x - px) * (a.y - py) - (a.x - px) * (c.y - py)) / area;
        const float w = 1 - u - v;
        if (u < 0 || v < 0 || w < 0) continue;
        const float z = u * a.z + v * b.z + w * c.z;
        const std::size_t at =
            static_cast<std::size_t>(y) * static_cast<std::size_t>(fine.x) + static_cast<std::size_t>(x);
        if (z <= depth[at]) continue;
        depth[at] = z;
        color[at] = u * a.color + v * b.color + w * c.color;
      }
    }
  }

  std::vector<std::uint8_t> rgb;
  rgb.reserve(static_cast<std::size_t>(pixels.x) * static_cast<std::size_t>(pixels.y) * 3);
  for (int y = 0; y < pixels.y; ++y) {
    for (int x = 0; x < pixels.x; ++x) {
      glm::vec3 sum(0);
      for (int k = 0; k < kFine * kFine; ++k) {
        sum += color[static_cast<std::size_t>(y * kFine + k / kFine) * static_cast<std::size_t>(fine.x) +
                     static_cast<std::size_t>(x * kFine + k % kFine)];
      }
      for (int k = 0; k < 3; ++k) {
        rgb.push_back(
            static_cast<std::uint8_t>(std::clamp(sum[k] / static_cast<float>(kFine * kFine) + 0.5f, 0.0f, 255.0f)));
      }
    }
  }
  return rgb;
}

}  // namespace typodont::session
