// The functions of the C interface for scenes and hands.
#include <cmath>
#include <filesystem>
#include <optional>

#include "engine/bindings/c/objects.h"
#include "haptics/scripted_hand.h"

using namespace typodont;
using namespace typodont::bindings;

namespace {

void give_scene(Scene scene, const char* model, typodont_scene** out) {
  choose_model(scene, model ? model : "");
  *out = make_handle<typodont_scene>(std::make_unique<SceneObject>(SceneObject{std::move(scene)}));
}

constexpr double kMinRate = 10, kMaxRate = 100'000;  // Hz, limits of a hand's rate, as for `typodont servo --rate`
void require_rate(double rate) {
  require(rate >= kMinRate && rate <= kMaxRate, "rate: expected 10 to 100000 Hz");
}

bool finite(const double* v, int n) {
  for (int i = 0; i < n; ++i) {
    if (!std::isfinite(v[i])) return false;
  }
  return true;
}

}  // namespace

typodont_result typodont_scene_open(const char* scene, const char* model, typodont_scene** out) {
  return guarded([&] {
    require(scene && out, "NULL for the scene's name or for the place of the handle");
    const SessionFiles files;  // locks access to HDF5, because a sphere packing is stored in an HDF5 file
    give_scene(read_scene(scene), model, out);
  });
}

typodont_result typodont_scene_parse(const char* json, const char* folder, const char* model, typodont_scene** out) {
  return guarded([&] {
    require(json && out, "NULL for the scene's text or for the place of the handle");
    const SessionFiles files;
    const std::filesystem::path beside = std::filesystem::absolute(folder ? folder : ".").lexically_normal();
    give_scene(parse_scene(Json::parse(json, "scene"), beside / "scene.json", ScenePlace(beside)), model, out);
  });
}

typodont_result typodont_scene_text(typodont_scene* scene, const char** json) {
  return with(scene, [&](SceneObject& s) {
    require(json, "NULL for the place of the text");
    *json = s.scene.text.c_str();
  });
}

typodont_result typodont_scene_tool(typodont_scene* scene, uint32_t place, const char** name) {
  return with(scene, [&](SceneObject& s) {
    require(name, "NULL for the place of the name");
    if (place >= s.tools.size()) return fail(TYPODONT_END, "the tray has no more tools");
    *name = s.tools[place].c_str();
    return typodont_result{TYPODONT_OK};
  });
}

typodont_result typodont_scene_model(typodont_scene* scene, const char** name) {
  return with(scene, [&](SceneObject& s) {
    require(name, "NULL for the place of the name");
    *name = s.model.c_str();
  });
}

typodont_result typodont_scene_free(typodont_scene* scene) {
  return free_handle(scene);
}

typodont_result typodont_hand_open(typodont_scene* scene, const char* address, double rate, typodont_hand** out) {
  return with(scene, [&](SceneObject& s) {
    require(address && out, "NULL for the hand's address or for the place of the handle");
    require_rate(rate);
    const SessionFiles files;
    *out =
        make_handle<typodont_hand>(std::make_unique<HandObject>(HandObject{open_unpaced_hand(s.scene, address, rate)}));
  });
}

typodont_result typodont_hand_path(const typodont_hand_row* rows, size_t count, double rate,
                                   const typodont_hand_model* model, typodont_hand** out) {
  return guarded([&] {
    require(rows && count > 0 && out, "NULL for the rows or for the place of the handle, or no row");
    require(sized(rows->struct_size, sizeof *rows), kBadSize);
    require_rate(rate);
    haptics::HandPath path;
    path.rows.reserve(count);
    for (std::size_t i = 0; i < count; ++i) {
      const typodont_hand_row& row = element(rows, i, rows->struct_size);
      require(finite(&row.t, 1) && finite(row.X_WT.p, 3) && finite(row.X_WT.q, 4) && finite(&row.pedal, 1) &&
                  finite(row.push, 3),
              "a row with a number that is not finite");
      require(row.t >= 0 && (i == 0 || row.t > path.rows.back().t), "times of rows: expected 0 or more, rising");
      const dquat R = to_pose(row.X_WT).R;
      require(std::abs(glm::length(R) - 1) < 1e-3, "a row with a quaternion that is not of unit length");
      path.rows.push_back({row.t, {to_vec(row.X_WT.p), glm::normalize(R)}, row.pedal, to_vec(row.push), row.tool});
    }
    std::unique_ptr<haptics::HapticDevice> device;
    if (model) {
      require(sized(model->struct_size, sizeof *model), kBadSize);
      require(model->mass > 0 && finite(&model->mass, 1) && finite(&model->damping, 1) && finite(model->stiffness, 3) &&
                  finite(model->push, 3),
              "a hand's model with a number that is not finite, or without mass");
      haptics::HandModel m;
      m.mass = model->mass;
      m.damping = model->damping;
      m.stiffness = to_vec(model->stiffness);
      m.push = to_vec(model->push);
      device = haptics::make_simulated_hand(std::move(path), m, rate, /*paced=*/false);
    } else {
      device = haptics::make_scripted_hand(std::move(path), rate, /*paced=*/false);
    }
    *out = make_handle<typodont_hand>(std::make_unique<HandObject>(HandObject{std::move(device)}));
  });
}

typodont_result typodont_hand_read(typodont_hand* hand, typodont_sample* out) {
  return with(hand, [&](HandObject& h) {
    require(out && sized(out->struct_size, sizeof *out), kBadSize);
    haptics::HandSample sample;
    if (!h.device->read(sample)) return fail(TYPODONT_END, "the hand has come to its end");
    out->tool = sample.tool;
    out->t_ns = sample.t;
    put(sample.X_WT, out->X_WT);
    out->pedal = sample.pedal;
    return typodont_result{TYPODONT_OK};
  });
}

typodont_result typodont_hand_write(typodont_hand* hand, const double* force, const double* torque) {
  return with(hand, [&](HandObject& h) {
    require(force && torque && finite(force, 3) && finite(torque, 3), "a force that is not finite, or NULL");
    h.device->write(to_vec(force), to_vec(torque));
  });
}

typodont_result typodont_hand_free(typodont_hand* hand) {
  return free_handle(hand);
}
