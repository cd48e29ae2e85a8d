#include "engine/app/operator/result_picture.h"

#include "engine/session/result_model.h"

namespace typodont {

render::Picture picture_of_result(const session::ReportOptions& report) {
  if (!report.result) return {};
  constexpr glm::ivec2 kPixels{560, 420};
  constexpr glm::vec3 kGround(32, 32, 33);  // sRGB, background colour of the panels
  const session::ModelView view =
      session::angled_view(report.preparation ? report.preparation->axis_W : dvec3(0, 0, 1));
  const bool compared = report.ideal.has_value();
  const std::vector<std::uint8_t> rgb = session::draw_model_pixels(*report.result, view, kPixels, compared, kGround);
  render::Picture picture{kPixels, {}};
  picture.rgba.reserve(rgb.size() / 3 * 4);
  for (std::size_t i = 0; i < rgb.size(); i += 3)
    picture.rgba.insert(picture.rgba.end(), {rgb[i], rgb[i + 1], rgb[i + 2], 255});
  return picture;
}

void ResultPicture::follow() {
  if (s_.outcome.picture.rgba == shown_) return;
  destroy();
  if (s_.outcome.picture.rgba.empty()) return;
  pictures_.add(s_.outcome.picture);
  pictures_.list(&s_.result_picture);
  shown_ = s_.outcome.picture.rgba;
}

void ResultPicture::destroy() {
  pictures_.clear();
  shown_.clear();
  s_.result_picture = nullptr;
}

}  // namespace typodont
