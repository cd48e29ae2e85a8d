#include "engine/app/operator/scene_pictures.h"

#include "engine/app/operator/child.h"
#include "engine/app/picture/quality_ladder.h"
#include "engine/base/cache.h"
#include "engine/base/error.h"
#include "engine/base/log.h"

namespace typodont {

namespace fs = std::filesystem;

namespace {

constexpr const char* kSuffix = ".png";
// A small picture at the level at which a session begins. If it exists, the caches are filled.
constexpr const char* kPreparedSuffix = ".prepared";
// A scene is prepared after it has been selected for this time, ns.
constexpr Nanos kPrepareAfter = kNanosPerSecond;
// Maximum picture cache size, bytes: over a hundred pictures.
constexpr std::uintmax_t kMaxKept = 64 << 20;

fs::path folder() {
  return cache::folder("pictures");
}

/// Key of a picture in the cache. It changes if the scene's file or the program changes.
std::uint64_t key_of(const fs::path& scene) {
  Sha256 key;
  cache::add_build(key);
  (void)cache::add_file(key, scene);
  return key.key();
}

/// Path of the scene's picture file; empty if there is none.
fs::path picture_of(const fs::path& scene) {
  std::error_code code;
  const fs::path own = fs::path(scene).replace_extension(kSuffix);
  return fs::is_regular_file(own, code) ? own : cache::find(folder(), key_of(scene), kSuffix);
}

}  // namespace

ScenePictures::~ScenePictures() {
  window_.wait_idle();
  destroy();
}

void ScenePictures::forget() {
  window_.wait_idle();
  destroy();
}

void ScenePictures::destroy() {
  for (gpu::Image& picture : s_.pictures) picture.destroy(window_.device());
  s_.pictures.clear();
  sought_.clear();
}

void ScenePictures::drop() {
  job_.reset();
  sought_.clear();
  selected_.clear();
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
  if (job_ && job_->done()) {
    if (job_->failure() && !preparing_) failed_.insert(drawn_);
    job_.reset();
    sought_.clear();
  }
  if (s_.scene < 0 || s_.scene >= std::ssize(s_.scenes)) return false;
  SceneChoice& scene = s_.scenes[static_cast<std::size_t>(s_.scene)];
  if (!scene.fault.empty()) return false;
  if (scene.picture >= 0) prepare(scene.file);
  if (scene.picture >= 0 || scene.file == sought_) return false;
  sought_ = scene.file;
  if (const fs::path picture = picture_of(scene.file); !picture.empty()) return take(scene, picture);
  if (preparing_) job_.reset();  // the picture is more urgent
  if (!job_ && !failed_.contains(scene.file)) draw(scene.file, kSuffix, "640x480", "medium");
  return false;
}

void ScenePictures::prepare(const fs::path& scene) {
  if (scene != selected_) selected_ = scene, selected_at_ = now();
  if (selected_at_ == 0 || job_ || now() - selected_at_ < kPrepareAfter) return;
  selected_at_ = 0;
  if (!cache::find(folder(), key_of(scene), kPreparedSuffix).empty()) return;
  const QualityLadder first = window_.device().processor ? QualityLadder::for_processor() : QualityLadder();
  draw(scene, kPreparedSuffix, "64x48", first.step().name);
  preparing_ = true;
}

void ScenePictures::draw(const fs::path& scene, const char* suffix, const char* size, std::string_view quality) {
  drawn_ = scene;
  preparing_ = false;
  job_ = std::make_unique<Job>([=](Progress& progress) {
    const bool kept = cache::keep(folder(), key_of(scene), suffix, kMaxKept, [&](const fs::path& file) {
      struct Drawn {  // its destructor removes the folder, even after an exception
        fs::path folder;
        ~Drawn() {
          std::error_code ignored;
          fs::remove_all(folder, ignored);
        }
      } drawn{fs::path(file).replace_extension()};
      run_self({"render", scene.string(), "--eye", "left", "--size", size, "--quality", std::string(quality), "--out",
                drawn.folder.string()},
               progress, kLowestPriority);
      fs::rename(drawn.folder / "left.png", file);
    });
    if (!kept) throw RunFailure("no picture");
  });
}

}  // namespace typodont
