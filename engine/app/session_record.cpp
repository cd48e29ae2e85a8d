#include "engine/app/session_record.h"

#include "engine/session/hash.h"
#include "haptics/solid.h"

namespace typodont {

session::SessionHeader session_header(const Scene& scene, const std::filesystem::path& rig_file,
                                      const haptics::HapticDevice& hand, const haptics::TissueVolume& tissue,
                                      double rate) {
  session::SessionHeader header;
  header.scene_json = scene.text;
  header.hand = hand.info().address;
  header.tools = tool_names(scene);
  header.servo_rate = rate;
  header.vibration_band = hand.info().vibration_band;
  header.position_step = hand.info().position_step;
  header.voxel = tissue.frame().voxel;
  header.volumes_before = scene.resume.empty() ? tissue.volumes() : load_untouched(scene).volumes();
  header.files.push_back(session::describe_file(std::filesystem::absolute(scene.file)));
  if (const auto volume = scene.tissue->find("volume")) {
    header.files.push_back(
        session::describe_file(std::filesystem::absolute(find_file(volume->string(), scene.file.parent_path()))));
  }
  const auto add_meshes = [&](const Json& solids) {
    for (const std::string& mesh : haptics::mesh_files(solids)) {
      header.files.push_back(session::describe_file(std::filesystem::absolute(find_file(mesh, scene.file.parent_path()))));
    }
  };
  add_meshes(*scene.tissue);
  for (const Json& item : scene.paint) add_meshes(item);
  for (const Json& item : scene.prepare) add_meshes(item);
  if (!scene.paint_file.empty()) header.files.push_back(session::describe_file(std::filesystem::absolute(scene.paint_file)));
  if (!scene.resume.empty()) {
    header.files.push_back(session::describe_file(std::filesystem::absolute(find_file(scene.resume, scene.file.parent_path()))));
  }
  if (!rig_file.empty()) {
    header.rig_json = Json::load(rig_file).text();
    header.files.push_back(session::describe_file(std::filesystem::absolute(rig_file)));
  }
  header.date = session::iso_date_now();
  return header;
}

session::StreamSpec left_hand_stream() {
  return {"left_hand",
          {{"x_m", "m"}, {"y_m", "m"}, {"z_m", "m"}, {"qw", ""}, {"qx", ""}, {"qy", ""}, {"qz", ""}, {"pedal", ""}}};
}

session::SessionResult session_result(const haptics::TissueVolume& tissue) {
  session::SessionResult result;
  result.volumes_after = tissue.volumes();
  result.has_volumes = true;
  result.field_hash = tissue.hash();
  return result;
}

}  // namespace typodont
