#include "tests/fuzz/targets.h"

#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>

#include "audio/ar_model.h"
#include "audio/contact_track.h"
#include "audio/sound_file.h"
#include "audio/sound_models.h"
#include "calibration/calibration_files.h"
#include "calibration/camera_solver.h"
#include "calibration/rig_file.h"
#include "calibration/routine.h"
#include "engine/app/scene.h"
#include "engine/app/scene/handpiece_file.h"
#include "engine/app/tissue/paint_file.h"
#include "engine/base/error.h"
#include "engine/base/json.h"
#include "engine/display/display_rig.h"
#include "engine/display/head_tracker.h"
#include "engine/render/handpiece_mesh.h"
#include "engine/render/picture.h"
#include "engine/session/packing_file.h"
#include "engine/session/remarks.h"
#include "engine/session/session_file.h"
#include "engine/session/ticks_csv.h"
#include "haptics/devices/arm.h"
#include "haptics/devices/arm_protocol.h"
#include "haptics/devices/haply.h"
#include "haptics/devices/hid_descriptor.h"
#include "haptics/devices/spacemouse.h"
#include "haptics/devices/websocket.h"
#include "haptics/import/import.h"
#include "haptics/import/mesh_tissue.h"
#include "haptics/mesh/editable_mesh.h"
#include "haptics/scripted_hand.h"
#include "haptics/spindle.h"
#include "haptics/tissue_volume.h"
#include "haptics/tool.h"
#include "tests/support/emulation/haply_service.h"

namespace typodont::test {

namespace {

using Bytes = std::span<const std::byte>;

std::string_view text_of(Bytes bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}
std::span<const std::uint8_t> octets_of(Bytes bytes) {
  return {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()};
}

/// Writes the bytes to a file of this name, in a folder of this process. The folder is in memory if the machine has
/// such a file system. Returns the path.
std::filesystem::path as_file(Bytes bytes, const char* name) {
  static const std::filesystem::path folder = [] {
    const std::filesystem::path memory = "/dev/shm";
    const auto base = std::filesystem::is_directory(memory) ? memory : std::filesystem::temp_directory_path();
    const auto made = base / ("typodont_fuzz_" + std::to_string(getpid()));
    std::filesystem::create_directories(made);
    std::atexit([] {
      std::error_code code;
      std::filesystem::remove_all(folder, code);
    });
    return made;
  }();
  const auto file = folder / name;
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  return file;
}

/// Calls a parser. It may read or refuse the bytes; both results are correct.
template <class F>
void attempt(F&& read) {
  try {
    read();
  } catch (const Error&) {
  } catch (const RunFailure&) {
  }
}

/// Limits the size of the result, whatever size the file states, because the test looks for errors of the parser and
/// not for long run times of the importer.
haptics::ImportOptions coarse() {
  haptics::ImportOptions options;
  options.voxel = 1e-3;
  return options;
}

template <const char* kName>
void import_as(Bytes bytes) {
  if (bytes.size() > 64 << 10) return;
  attempt([&] { (void)haptics::import_tissue(as_file(bytes, kName), coarse()); });
}
/// Reads a file as the tissue of a scene: it is read, converted to a mesh that can be cut and, if it is small, to a
/// volume.
template <const char* kName>
void tissue_as(Bytes bytes) {
  constexpr double kSmall = 30e-3;  // m
  if (bytes.size() > 64 << 10) return;
  attempt([&] {
    const haptics::TissueMesh mesh = haptics::read_tissue_mesh(as_file(bytes, kName), 1e-3, Tissue::kEnamel).mesh;
    const haptics::mesh::EditableMesh editable(mesh, 1e-3, 16);
    dvec3 lo(1e300), hi(-1e300);
    for (const dvec3& p : mesh.vertices) lo = glm::min(lo, p), hi = glm::max(hi, p);
    if (glm::all(glm::lessThan(hi - lo, dvec3(kSmall)))) (void)haptics::rasterize(mesh, {.voxel = 1e-3});
  });
}
constexpr char kNrrd[] = "in.nrrd", kNifti[] = "in.nii", kMeta[] = "in.mha", kStl[] = "in.stl", kPly[] = "in.ply",
               k3mf[] = "in.3mf", kObj[] = "in.obj", kGltf[] = "in.gltf", kGlb[] = "in.glb", kDicom[] = "in.dcm",
               kZip[] = "in.zip";

void json(Bytes bytes) {
  attempt([&] { (void)Json::parse(text_of(bytes), "fuzz").text(); });
}
void scene(Bytes bytes) {
  attempt([&] { (void)parse_scene(Json::parse(text_of(bytes), "fuzz"), "fuzz.json"); });
}
void display_rig(Bytes bytes) {
  attempt([&] { (void)display::parse_rig(Json::parse(text_of(bytes), "fuzz")); });
}
void rig_file(Bytes bytes) {
  attempt([&] { (void)calibration::RigFile::load(as_file(bytes, "rig.json")); });
}
void hand_csv(Bytes bytes) {
  attempt([&] { (void)haptics::read_hand_path(as_file(bytes, "hand.csv")); });
}
void ticks_csv(Bytes bytes) {
  attempt([&] { (void)session::read_ticks_csv(as_file(bytes, "ticks.csv")); });
}
void calibration_csv(Bytes bytes) {
  const auto file = as_file(bytes, "captures.csv");
  attempt([&] { (void)calibration::read_points(file); });
  attempt([&] { (void)calibration::read_sightings(file); });
  attempt([&] { (void)calibration::read_arm_captures(file); });
  attempt([&] { (void)calibration::read_mark_captures(file); });
  attempt([&] { (void)calibration::read_touches(file); });
  attempt([&] { (void)calibration::read_eye_captures(file); });
  attempt([&] { (void)calibration::read_pair_captures(file); });
  attempt([&] { (void)calibration::read_pairs(file); });
  attempt([&] { (void)calibration::read_stream(file); });
  attempt([&] {  // also calls the solver: it must accept the number of rows that were read
    const calibration::PosePairs pairs = calibration::read_pose_pairs(file);
    if (pairs.A.size() > 64) return;
    (void)calibration::hand_eye_json(calibration::solve_hand_eye(pairs.A, pairs.B), "X_SM", "X_HK");
  });
}
void contact_csv(Bytes bytes) {
  attempt([&] { (void)audio::read_contact_track(as_file(bytes, "contact.csv")); });
}
void sound_model(Bytes bytes) {
  const auto file = as_file(bytes, "model.json");
  attempt([&] { (void)audio::load_model(file); });
  attempt([&] { (void)audio::load_sound_models(file); });
}
void recording_wav(Bytes bytes) {
  attempt([&] { (void)audio::read_recording(as_file(bytes, "in.wav")); });
}
void volume_vdb(Bytes bytes) {
  attempt([&] { (void)haptics::TissueVolume::load(as_file(bytes, "in.vdb")).hash(); });
}
void session_h5(Bytes bytes) {
  attempt([&] {
    const session::SessionReader reader(as_file(bytes, "in.h5"));
    (void)reader.ticks(0, 1000);
  });
}
void packing_h5(Bytes bytes) {
  attempt([&] { (void)session::load_packing(as_file(bytes, "in.h5")).coverage(); });
}
void picture_png(Bytes bytes) {
  attempt([&] { (void)render::read_png(as_file(bytes, "in.png")); });
}
void opentrack(Bytes bytes) {
  (void)display::parse_opentrack(bytes);
  (void)display::parse_tracker_address(text_of(bytes));
}
/// Reads reports of a device. The first byte chooses the protocol.
void device_reports(Bytes bytes) {
  if (bytes.empty()) return;
  using haptics::ArmProtocol;
  constexpr ArmProtocol kProtocols[] = {ArmProtocol::kHidV1, ArmProtocol::kHidV2, ArmProtocol::kRawHid};
  (void)haptics::parse_hid(kProtocols[std::to_integer<unsigned>(bytes[0]) % 3], octets_of(bytes.subspan(1)));
  haptics::LineAssembler lines;
  lines.add(octets_of(bytes.subspan(1)));
  if (const auto line = lines.take()) (void)haptics::parse_text(*line);
  haptics::SpaceMouseState state;
  (void)haptics::parse_spacemouse(octets_of(bytes.subspan(1)), state);
  (void)haptics::parse_haply(text_of(bytes.subspan(1)));
}
/// Reads a HID descriptor, whose length is the first byte, and a report that it describes.
void hid_descriptor(Bytes bytes) {
  if (bytes.empty()) return;
  const std::size_t size = std::min<std::size_t>(std::to_integer<std::size_t>(bytes[0]), bytes.size() - 1);
  const auto report = octets_of(bytes.subspan(1 + size));
  for (const haptics::HidField& field : haptics::parse_descriptor(octets_of(bytes.subspan(1, size))))
    (void)haptics::field_value(field, report);
}

void tool(Bytes bytes) {
  attempt([&] { (void)haptics::read_tool(Json::parse(text_of(bytes), "fuzz")); });
}
void handpiece(Bytes bytes) {
  attempt([&] { (void)render::make_handpiece_mesh(read_handpiece(Json::parse(text_of(bytes), "fuzz")), 1e-3); });
}
void motor(Bytes bytes) {
  attempt([&] { (void)haptics::read_spindle(Json::parse(text_of(bytes), "fuzz")); });
}
void remarks(Bytes bytes) {
  attempt([&] { (void)session::remarks_from(Json::parse(text_of(bytes), "fuzz")); });
}
void arm_preset(Bytes bytes) {
  attempt([&] { (void)haptics::read_arm(as_file(bytes, "arm.json")); });
}
void paint_strokes(Bytes bytes) {
  attempt([&] { (void)read_paint(as_file(bytes, "paint.json")); });
}
/// Reads the model of a hand: a JSON file in the same folder as the path that it names.
void hand_model(Bytes bytes) {
  constexpr std::string_view kPath = "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n0,0,0,0,1,0,0,0,0\n1,1,0,0,1,0,0,0,1\n";
  as_file(std::as_bytes(std::span(kPath)), "path.csv");
  attempt([&] {
    haptics::HandSample sample;
    const auto hand = haptics::open_scripted_hand(as_file(bytes, "model.json"), 1000, false);
    for (int i = 0; i < 10 && hand->read(sample); ++i) hand->write(dvec3(0, 0, 1), dvec3(0));
  });
}
/// A service that makes a correct handshake, and sends a state and then these bytes.
class Service : public haptics::Link {
 public:
  explicit Service(Bytes bytes) : said_(text_of(bytes)) {}
  int read(std::span<std::uint8_t> buffer, Nanos) noexcept override {
    const std::size_t n = std::min(buffer.size(), said_.size() - at_);
    if (n == 0) return -1;
    std::copy_n(said_.begin() + static_cast<std::ptrdiff_t>(at_), n, buffer.begin());
    at_ += n;
    return static_cast<int>(n);
  }
  bool write(std::span<const std::uint8_t> bytes) noexcept override {
    if (!service_.open) said_.insert(0, service_.feed({bytes.begin(), bytes.end()}));
    return true;
  }

 private:
  HaplyService service_;
  std::string said_;
  std::size_t at_ = 0;
};
void websocket(Bytes bytes) {
  attempt([&] {
    haptics::WebSocket socket(std::make_unique<Service>(bytes), "fuzz", "/");
    std::string_view message;
    for (auto got = haptics::WebSocket::Got::kMessage; got == haptics::WebSocket::Got::kMessage;) {
      got = socket.receive(message, 0);
      if (got == haptics::WebSocket::Got::kMessage) (void)haptics::parse_haply(message);
    }
  });
}

constexpr FuzzTarget kTargets[] = {{"json", json},
                                   {"scene", scene},
                                   {"display_rig", display_rig},
                                   {"rig_file", rig_file},
                                   {"hand_csv", hand_csv},
                                   {"ticks_csv", ticks_csv},
                                   {"calibration_csv", calibration_csv},
                                   {"contact_csv", contact_csv},
                                   {"sound_model", sound_model},
                                   {"recording_wav", recording_wav},
                                   {"volume_vdb", volume_vdb},
                                   {"session_h5", session_h5},
                                   {"packing_h5", packing_h5},
                                   {"picture_png", picture_png},
                                   {"scan_nrrd", import_as<kNrrd>},
                                   {"scan_nifti", import_as<kNifti>},
                                   {"scan_metaimage", import_as<kMeta>},
                                   {"scan_dicom", import_as<kDicom>},
                                   {"scan_zip", import_as<kZip>},
                                   {"mesh_3mf", import_as<k3mf>},
                                   {"mesh_stl", import_as<kStl>},
                                   {"mesh_ply", import_as<kPly>},
                                   {"mesh_obj", import_as<kObj>},
                                   {"tissue_stl", tissue_as<kStl>},
                                   {"tissue_gltf", tissue_as<kGltf>},
                                   {"tissue_glb", tissue_as<kGlb>},
                                   {"opentrack", opentrack},
                                   {"device_reports", device_reports},
                                   {"hid_descriptor", hid_descriptor},
                                   {"tool", tool},
                                   {"remarks", remarks},
                                   {"handpiece", handpiece},
                                   {"motor", motor},
                                   {"arm_preset", arm_preset},
                                   {"paint_strokes", paint_strokes},
                                   {"hand_model", hand_model},
                                   {"websocket", websocket}};

}  // namespace

std::span<const FuzzTarget> fuzz_targets() {
  return kTargets;
}

}  // namespace typodont::test
