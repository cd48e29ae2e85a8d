// Exercises, hands and pictures, and the selection, which is stored between runs. Main thread only.
#pragma once

#include <filesystem>
#include <string>

#include "engine/app/operator/interface_window.h"
#include "engine/app/operator/scene_pictures.h"
#include "engine/app/operator/state.h"
#include "haptics/devices.h"

namespace typodont {

class Choices {
 public:
  /// Restores the last selection.
  Choices(OperatorState& s, InterfaceWindow& w);

  /// No change without a font for the language.
  void set_language(session::Language language);
  /// Searches scenes, hands and rigs again; keeps the selection.
  void rescan();
  void choose_scene(const std::filesystem::path& file);
  void choose_tutorial();
  void remember() const;

  /// While the user selects a hand. True: devices have changed.
  bool look_at_devices();
  ScenePictures& pictures() { return pictures_; }

 private:
  void choose_hand(const std::string& address);

  OperatorState& s_;
  InterfaceWindow& window_;
  ScenePictures pictures_;
  haptics::DeviceWatch plugged_;
  Nanos plugged_looked_ = 0;
};

}  // namespace typodont
