#include "engine/app/picture/film_picture.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

namespace typodont {

namespace {

// Thickness of water at which its effect on the picture is 63 % (1 − 1/e) of the largest effect, m. Must equal the
// value in film.glsl.
constexpr double kWaterDepth = 80e-6;
// Thickness of a layer of solid grains that hides 63 % (1 − 1/e) of the surface, m; for grains of 5 to 10 µm, each of
// which hides its cross-section.
constexpr double kSolidsDepth = 4e-6;
// A texel is drawn again if one of its values (0 to 255) has changed by at least this. A smaller change is not visible.
constexpr int kVisible = 10;

std::uint8_t byte(double fraction) {
  return static_cast<std::uint8_t>(std::lround(255 * std::clamp(fraction, 0.0, 1.0)));
}

render::FilmTexel texel_of(const debris::FilmCell& cell) {
  double solids = 0, tint = 0, blood = 0;
  for (std::size_t t = 0; t < kTissueCount; ++t) {
    const double height = cell.solids[t];
    const auto tissue = static_cast<Tissue>(t);
    solids += height;
    if (tissue == Tissue::kPulp || tissue == Tissue::kGingiva)
      blood += height;
    else
      tint += height * (tissue == Tissue::kCaries ? 1 : tissue == Tissue::kEnamel ? 0 : 0.5);
  }
  const double white = solids - blood;
  return {.water = byte(-std::expm1(-cell.water / kWaterDepth)),
          .cover = byte(-std::expm1(-solids / kSolidsDepth)),
          .colour = byte(white > 0 ? tint / white : 0),
          .blood = byte(solids > 0 ? blood / solids : 0)};
}

/// True if two texels of the film look different. A difference in the solids' colour counts in proportion to the
/// fraction of the surface that they cover.
bool differ(const render::FilmTexel& a, const render::FilmTexel& b) {
  const auto apart = [](std::uint8_t x, std::uint8_t y) { return std::abs(int{x} - int{y}); };
  const int cover = std::max(a.cover, b.cover);
  return apart(a.water, b.water) >= kVisible || apart(a.cover, b.cover) >= kVisible ||
         apart(a.colour, b.colour) * cover / 255 >= kVisible || apart(a.blood, b.blood) * cover / 255 >= kVisible;
}

}  // namespace

FilmPicture::FilmPicture(const debris::CoarseField& field, std::uint64_t version)
    : grid_{field.origin, field.spacing, field.size}, blocks_((field.size + kBlock - 1) / kBlock), version_(version) {
  const std::size_t samples = voxel_count(grid_.size);
  own_.resize(samples);
  texels_.resize(samples);
  queued_.resize(samples);
  block_version_.resize(voxel_count(blocks_), version);
}

void FilmPicture::update(debris::Film& film) {
  changed_.clear();
  film.take_changed(changed_);
  if (changed_.empty()) return;
  queue_.clear();
  for (const glm::ivec3& sample : changed_) {
    const debris::FilmCell cell = film.cell(sample);
    const render::FilmTexel texel = cell.area > 0 ? texel_of(cell) : render::FilmTexel{};
    render::FilmTexel& own = own_[index(sample)];
    if (!differ(own, texel) && (texel != render::FilmTexel{} || own == texel)) continue;
    own = texel;
    for_each_voxel_between(sample - 1, sample + 1, [&](const glm::ivec3& s) {
      if (std::exchange(queued_[index(s)], std::uint8_t{1}) == 0) queue_.push_back(s);
    });
  }
  if (queue_.empty()) return;
  ++version_;
  for (const glm::ivec3& sample : queue_) {
    queued_[index(sample)] = 0;
    write(film, sample);
  }
}

/// Writes the texel of a grid point: the values of its film cell. A grid point without a cell gets the mean of its
/// neighbours' cells; otherwise the interpolated film would fade near the surface.
void FilmPicture::write(const debris::Film& film, const glm::ivec3& sample) {
  render::FilmTexel texel = own_[index(sample)];
  if (!film.has_cell(sample)) {
    int count = 0;
    glm::ivec4 sum(0);
    for_each_voxel_between(sample - 1, sample + 1, [&](const glm::ivec3& s) {
      if (!film.has_cell(s)) return;
      const render::FilmTexel& t = own_[index(s)];
      sum += glm::ivec4(t.water, t.cover, t.colour, t.blood);
      ++count;
    });
    sum = count > 0 ? (sum + count / 2) / count : glm::ivec4(0);
    texel = {static_cast<std::uint8_t>(sum.x), static_cast<std::uint8_t>(sum.y), static_cast<std::uint8_t>(sum.z),
             static_cast<std::uint8_t>(sum.w)};
  }
  render::FilmTexel& shown = texels_[index(sample)];
  if (shown == texel) return;
  shown = texel;
  ++texels_written_;
  block_version_[voxel_index(sample / kBlock, blocks_)] = version_;
}

void FilmPicture::show(const FilmPicture* picture, render::Renderer& renderer, Shown& shown) {
  if (picture != shown.picture) {
    renderer.set_film(picture ? picture->grid_ : render::FilmGrid{});
    shown = {picture, 0};
  }
  if (!picture || picture->version_ == shown.version) return;
  std::vector<render::CellBox> boxes;
  for_each_voxel(picture->blocks_, [&](const glm::ivec3& b) {
    if (picture->block_version_[voxel_index(b, picture->blocks_)] > shown.version)
      boxes.push_back({b * kBlock, glm::min(b * kBlock + kBlock, picture->grid_.size) - 1});
  });
  shown.version = picture->version_;
  if (!boxes.empty()) renderer.update_film(picture->texels_, boxes);
}

}  // namespace typodont
