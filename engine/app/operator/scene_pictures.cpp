#include "engine/app/operator/scene_pictures.h"

#include "engine/app/operator/child.h"
#include "engine/app/picture/quality_ladder.h"
#include "engine/base/cache.h"
#include "engine/base/error.h"
#include "engine/base/log.h"
#include "engine/base/progress.h"
#include "engine/base/temporary_folder.h"

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

/// Draws a picture of the scene in another process, and keeps it in the cache. False: this is impossible.
bool draw_scene(const fs::path& scene, const char* suffix, const char* size, std::string_view quality,
                Progress& progress) {
  const bool kept = cache::keep(folder(), key_of(scene), suffix, kMaxKept, [&](const fs::path& file) {
    const TemporaryFolder drawn;
    run_self({"render", scene.string(), "--eye", "left", "--size", size, "--quality", std::string(quality), "--out",
              drawn.path().string()},
             progress, kLowestPriority);
    fs::copy_file(drawn.path() / "left.png", file, fs::copy_options::overwrite_existing);
  });
  progress.at(1);
  return kept;
}

/// The scene's picture: the file beside the scene, or the one in the cache, which is drawn if it is missing. Empty:
/// this is impossible.
std::optional<render::Picture> picture_of(const fs::path& scene, Progress& progress) {
  std::error_code code;
  fs::path file = fs::path(scene).replace_extension(kSuffix);
  const auto cached = [&] { return cache::find(folder(), key_of(scene), kSuffix); };
  if (!fs::is_regular_file(file, code)) file = cached();
  if (file.empty() && draw_scene(scene, kSuffix, "640x480", "medium", progress)) file = cached();
  if (file.empty()) return std::nullopt;
  try {
    return render::read_png(file);
  } catch (const Error& e) {
    log::warn("{}", e.what());
    return std::nullopt;
  }
}

}  // namespace

void ScenePictures::drop() {
  job_.drop();
  selected_.clear();
}

bool ScenePictures::look() {
  const bool ended = job_.look();
  const fs::path scene = s_.can_start() ? s_.selected_scene()->file : fs::path();
  if (scene != selected_) {
    job_.cancel();  // the work for the selected exercise is more urgent
    selected_ = scene;
    selected_at_ = now();
    prepared_ = false;
  }
  if (scene.empty() || job_.under_way() || failed_.contains(scene)) return ended;
  if (s_.selected_scene()->picture < 0)
    load();
  else if (!prepared_ && now() - selected_at_ >= kPrepareAfter)
    prepare();
  return ended;
}

void ScenePictures::load() {
  job_.make([scene = selected_](Progress& progress) { return picture_of(scene, progress); },
            [this, scene = selected_](const std::optional<render::Picture>& picture) {
              if (!picture) return void(failed_.insert(scene));
              s_.pictures.push_back(window_.upload(*picture));
              for (SceneChoice& choice : s_.scenes)
                if (choice.file == scene) choice.picture = static_cast<int>(s_.pictures.size()) - 1;
            },
            [this, scene = selected_](const std::exception& e) {
              if (!dynamic_cast<const Cancelled*>(&e)) failed_.insert(scene);
            });
}

void ScenePictures::prepare() {
  prepared_ = true;
  const QualityLadder first = window_.device().processor ? QualityLadder::for_processor() : QualityLadder();
  job_.begin(
      [scene = selected_, quality = first.step().name](Progress& progress) {
        if (cache::find(folder(), key_of(scene), kPreparedSuffix).empty())
          draw_scene(scene, kPreparedSuffix, "64x48", quality, progress);
      },
      {}, [](const std::exception&) {});  // cancelled
}

}  // namespace typodont
