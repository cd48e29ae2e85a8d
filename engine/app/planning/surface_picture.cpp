#include "engine/app/planning/surface_picture.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace typodont {

SurfacePicture::SurfacePicture(haptics::TissueMesh mesh, std::vector<glm::vec3> colors)
    : surface_(std::make_shared<const Surface>(Surface{std::move(mesh), std::move(colors)})) {
  const std::vector<dvec3>& vertices = surface_->mesh.vertices;
  if (vertices.empty()) return;
  dvec3 lo(vertices.front()), hi(lo);
  for (const dvec3& p : vertices) lo = glm::min(lo, p), hi = glm::max(hi, p);
  centre_ = 0.5 * (lo + hi);
  constexpr double kMargin = 1.05;
  extent_ = kMargin * glm::length(hi - lo);
}

void SurfacePicture::look_along(const dvec3& look, const dvec3& up) {
  look_ = look;
  right_ = glm::normalize(glm::cross(look, up));
  up_ = glm::cross(right_, look);
}

void SurfacePicture::look_like(const SurfacePicture& other) {
  if (other.surface_->mesh.vertices.empty()) return;
  centre_ = other.centre_, extent_ = other.extent_;
  right_ = other.right_, up_ = other.up_, look_ = other.look_;
}

void SurfacePicture::turn(const dvec2& by) {
  constexpr double kTurn = 3.5;  // rad, rotation of the surface by a drag across the whole picture
  const dquat R = glm::angleAxis(-kTurn * by.x, up_) * glm::angleAxis(-kTurn * by.y, right_);
  look_along(glm::normalize(R * look_), R * up_);
}

void SurfacePicture::zoom(double factor) {
  constexpr double kMin = 3e-3, kMax = 1;  // m, limits of the width of the picture
  extent_ = std::clamp(extent_ / factor, kMin, kMax);
}

dvec2 SurfacePicture::place_of(const dvec3& p) const {
  const dvec3 from = p - centre_;
  return {0.5 + glm::dot(from, right_) / extent_, 0.5 - glm::dot(from, up_) / extent_};
}

void SurfacePicture::add(const haptics::TissueMesh& mesh, const std::vector<glm::vec3>& colors) {
  Surface both = *surface_;
  const auto first = static_cast<unsigned>(both.mesh.vertices.size());
  both.mesh.vertices.insert(both.mesh.vertices.end(), mesh.vertices.begin(), mesh.vertices.end());
  for (const glm::uvec3& t : mesh.triangles) both.mesh.triangles.push_back(t + first);
  both.colors.insert(both.colors.end(), colors.begin(), colors.end());
  surface_ = std::make_shared<const Surface>(std::move(both));
}

render::Picture SurfacePicture::draw(int pixels) {
  constexpr float kNothing = std::numeric_limits<float>::infinity();
  constexpr std::uint8_t kGround = 32;
  const haptics::TissueMesh& mesh = surface_->mesh;
  const auto count = static_cast<std::size_t>(pixels) * static_cast<std::size_t>(pixels);
  drawn_ = {pixels, std::vector<float>(count, kNothing), centre_, right_, up_, look_, extent_};
  render::Picture picture{{pixels, pixels}, std::vector<std::uint8_t>(4 * count, kGround)};
  for (std::size_t i = 0; i < count; ++i) picture.rgba[4 * i + 3] = 255;
  // Projects vertices: x and y in pixels, depth in m.
  std::vector<glm::vec3> seen;
  seen.reserve(mesh.vertices.size());
  for (const dvec3& p : mesh.vertices) {
    const dvec2 at = place_of(p) * static_cast<double>(pixels);
    seen.emplace_back(at.x - 0.5, at.y - 0.5, glm::dot(p - centre_, look_));
  }
  const dvec3 light = glm::normalize(-look_ + 0.5 * up_ - 0.4 * right_);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const glm::uvec3& c = mesh.triangles[t];
    const glm::vec3 &a = seen[c.x], &b = seen[c.y], &d = seen[c.z];
    const float area = (b.x - a.x) * (d.y - a.y) - (b.y - a.y) * (d.x - a.x);
    if (area == 0) continue;
    const int x0 = std::max(0, static_cast<int>(std::ceil(std::min({a.x, b.x, d.x})))),
              x1 = std::min(pixels - 1, static_cast<int>(std::floor(std::max({a.x, b.x, d.x})))),
              y0 = std::max(0, static_cast<int>(std::ceil(std::min({a.y, b.y, d.y})))),
              y1 = std::min(pixels - 1, static_cast<int>(std::floor(std::max({a.y, b.y, d.y}))));
    if (x0 > x1 || y0 > y1) continue;
    const dvec3 &p = mesh.vertices[c.x], &q = mesh.vertices[c.y], &r = mesh.vertices[c.z];
    const dvec3 normal = glm::cross(q - p, r - p);
    const double length = glm::length(normal);
    // Lights both sides: the back of a scan is visible.
    const double lit = length > 0 ? std::abs(glm::dot(normal, light)) / length : 0;
    const glm::vec3 color = surface_->colors[t] * static_cast<float>(0.25 + 0.75 * lit);
    for (int y = y0; y <= y1; ++y) {
      for (int x = x0; x <= x1; ++x) {
        const auto fx = static_cast<float>(x), fy = static_cast<float>(y);
        const float u = ((fx - a.x) * (d.y - a.y) - (fy - a.y) * (d.x - a.x)) / area;
        const float v = ((b.x - a.x) * (fy - a.y) - (b.y - a.y) * (fx - a.x)) / area;
        if (u < 0 || v < 0 || u + v > 1) continue;
        const float depth = a.z + u * (b.z - a.z) + v * (d.z - a.z);
        const std::size_t i =
            static_cast<std::size_t>(y) * static_cast<std::size_t>(pixels) + static_cast<std::size_t>(x);
        if (depth >= drawn_.depth[i]) continue;
        drawn_.depth[i] = depth;
        for (int k = 0; k < 3; ++k)
          picture.rgba[4 * i + static_cast<std::size_t>(k)] = static_cast<std::uint8_t>(std::lround(color[k]));
      }
    }
  }
  return picture;
}

std::optional<dvec3> SurfacePicture::at(const dvec2& place) const {
  const int pixels = drawn_.pixels;
  const int x = static_cast<int>(std::floor(place.x * pixels)), y = static_cast<int>(std::floor(place.y * pixels));
  if (x < 0 || y < 0 || x >= pixels || y >= pixels) return std::nullopt;
  const float depth =
      drawn_.depth[static_cast<std::size_t>(y) * static_cast<std::size_t>(pixels) + static_cast<std::size_t>(x)];
  if (!std::isfinite(depth)) return std::nullopt;
  const dvec2 middle((x + 0.5) / pixels, (y + 0.5) / pixels);
  return drawn_.centre + (middle.x - 0.5) * drawn_.extent * drawn_.right +
         (0.5 - middle.y) * drawn_.extent * drawn_.up + static_cast<double>(depth) * drawn_.look;
}

}  // namespace typodont
