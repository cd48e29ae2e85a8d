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
  image_ = window_.upload(s_.outcome.picture);
  shown_ = s_.outcome.picture.rgba;
  s_.result_picture = &*image_;
}

void ResultPicture::destroy() {
  if (!image_) return;
  window_.wait_idle();
  image_->destroy(window_.device());
  image_.reset();
  shown_.clear();
  s_.result_picture = nullptr;
}

}  // namespace typodont
