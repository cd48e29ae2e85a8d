#include "engine/app/operator/scene_pictures.h"

#include <algorithm>

#include "engine/app/operator/child.h"
#include "engine/app/operator/library.h"
#include "engine/base/error.h"
#include "engine/base/log.h"

namespace typodont {

namespace fs = std::filesystem;

ScenePictures::~ScenePictures() {
  window_.wait_idle();
  destroy();
}

void ScenePictures::load(const std::vector<fs::path>& files) {
  window_.wait_idle();
  destroy();
  for (std::size_t i = 0; i < files.size(); ++i)
    if (!files[i].empty()) take(s_.scenes[i], files[i]);
}

void ScenePictures::destroy() {
  for (gpu::Image& picture : s_.pictures) picture.destroy(window_.device());
  s_.pictures.clear();
}

bool ScenePictures::take(SceneChoice& scene, const fs::path& picture) {
  try {
    s_.pictures.push_back(window_.upload(render::read_png(picture)));
    scene.picture = static_cast<int>(s_.pictures.size()) - 1;
    return true;
  } catch (const Error& e) {
    log::warn("{}", e.what());
    return false;
  }
}

bool ScenePictures::look() {
  if (!job_) {
    begin();
    return false;
  }
  if (!job_->done()) return false;
  const bool made = !job_->failure();
  job_.reset();
  bool came = false;
  for (SceneChoice& scene : s_.scenes)
    if (made && scene.file == drawn_ && scene.picture < 0) came = take(scene, made_picture(drawn_));
  return came;
}

void ScenePictures::begin() {
  const auto wanting = [&](const SceneChoice& scene) {
    return scene.picture < 0 && scene.fault.empty() && !tried_.contains(scene.file);
  };
  auto scene = s_.scenes.begin() + std::min<std::ptrdiff_t>(s_.scene, std::ssize(s_.scenes));
  if (scene == s_.scenes.end() || !wanting(*scene)) scene = std::find_if(s_.scenes.begin(), s_.scenes.end(), wanting);
  if (scene == s_.scenes.end()) return;
  drawn_ = scene->file;
  tried_.insert(drawn_);
  job_ = std::make_unique<Job>([file = drawn_](Progress& progress) {
    const fs::path picture = made_picture(file), folder = fs::path(picture).replace_extension();
    run_self({"render", file.string(), "--eye", "left", "--size", "640x480", "--out", folder.string()}, progress,
             kLowestPriority);
    std::error_code code;
    fs::rename(folder / "left.png", picture, code);
    std::error_code ignored;
    fs::remove_all(folder, ignored);
    if (code) throw RunFailure("no picture");
  });
}

}  // namespace typodont
