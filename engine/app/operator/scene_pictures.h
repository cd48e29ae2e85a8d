// The picture of the selected exercise. Only this picture is shown, so no other is loaded or drawn. Main thread only.
#pragma once

#include <filesystem>
#include <memory>
#include <set>

#include "engine/app/operator/interface_window.h"
#include "engine/app/operator/job.h"
#include "engine/app/operator/state.h"

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
  /// was loaded.
  bool look();
  /// Cancels the drawing of a picture.
  void drop();

 private:
  bool take(SceneChoice& scene, const std::filesystem::path& picture);
  void begin(const std::filesystem::path& scene);

  OperatorState& s_;
  InterfaceWindow& window_;
  std::unique_ptr<Job> job_;
  std::filesystem::path drawn_;             // the scene whose picture is being drawn
  std::filesystem::path sought_;            // the scene whose picture was last searched for
  std::set<std::filesystem::path> failed_;  // scenes whose picture could not be drawn
};

}  // namespace typodont
