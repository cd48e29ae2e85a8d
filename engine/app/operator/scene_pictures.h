// The picture of the selected exercise. Only this picture is shown, so no other is loaded or drawn. Also prepares the
// exercise's first session. Main thread only.
#pragma once

#include <filesystem>
#include <memory>
#include <set>

#include "engine/app/operator/interface_window.h"
#include "engine/app/operator/job.h"
#include "engine/app/operator/state.h"
#include "engine/base/clock.h"

namespace typodont {

class ScenePictures {
 public:
  ScenePictures(OperatorState& s, InterfaceWindow& w) : s_(s), window_(w) {}
  ~ScenePictures();
  ScenePictures(const ScenePictures&) = delete;
  ScenePictures& operator=(const ScenePictures&) = delete;

  /// Forgets all pictures; for a new list of scenes.
  void forget();
  /// Destroys the pictures. The GPU must not be using them.
  void destroy();
  /// Loads the picture: NAME.png beside the scene, or from the cache; otherwise draws it in the background. True: it
  /// was loaded. If the scene stays selected, fills the caches in the background. A session then starts faster.
  bool look();
  /// Cancels the work in the background.
  void drop();

 private:
  bool take(SceneChoice& scene, const std::filesystem::path& picture);
  void prepare(const std::filesystem::path& scene);
  void draw(const std::filesystem::path& scene, const char* suffix, const char* size, std::string_view quality);

  OperatorState& s_;
  InterfaceWindow& window_;
  std::unique_ptr<Job> job_;
  std::filesystem::path drawn_;             // the scene for which job_ works
  std::filesystem::path sought_;            // the scene whose picture was last searched for
  bool preparing_ = false;                  // true: job_ only fills the caches
  std::set<std::filesystem::path> failed_;  // scenes that could not be drawn
  std::filesystem::path selected_;          // the scene of the last call of prepare()
  Nanos selected_at_ = 0;                   // ns, first call of prepare() for this scene
};

}  // namespace typodont
