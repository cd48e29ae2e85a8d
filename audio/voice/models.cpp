#include <cmath>

#include "audio/sound_models.h"
#include "audio/voice/work_level.h"
#include "engine/base/json.h"
#include "engine/base/units.h"

namespace typodont::audio {

SoundModels load_sound_models(const std::filesystem::path& file) {
  const Json json = Json::load(file);
  SoundModels models;
  if (!json.is_object()) json.fail("an object");
  if (const auto kind = json.find("kind"); !kind || kind->string() != "voice") {
    models.idle = load_model(file);
    models.name = models.idle.name;
    models.source = models.idle.source;
    models.licence = models.idle.licence;
    models.free_speed = models.idle.spindle;
    return models;
  }
  json.allow_only({"kind", "name", "idle", "working", "free_speed_krpm", "order", "tones", "teeth", "level_dB", "work",
                   "spray", "source", "licence", "notes"});
  const auto model_beside = [&](const Json& name) {
    const std::filesystem::path path = file.parent_path() / name.string();
    std::error_code code;
    if (!std::filesystem::is_regular_file(path, code)) name.fail("a model file beside this one");
    return load_model(path);
  };
  models.name = json.string_or("name", file.stem().string());
  models.source = json.string_or("source", "");
  models.licence = json.string_or("licence", "");
  models.idle = model_beside(json["idle"]);
  if (const auto order = json.find("order")) {
    models.idle = truncated(models.idle, static_cast<std::size_t>(order->integer(1, 5000)));
  }
  if (const auto working = json.find("working")) {
    for (const std::string& key : working->keys()) {
      const auto tissue = tissue_named(key);
      if (!tissue || *tissue == Tissue::kAir) (*working)[key].fail("\"" + key + "\"", "a tissue's name as key");
      models.working[static_cast<std::size_t>(*tissue)] = model_beside((*working)[key]);
    }
  }
  models.free_speed = json.number_or("free_speed_krpm", models.idle.spindle / kKrpm, 0, 1000) * kKrpm;
  if (const auto tones = json.find("tones")) {
    for (const Json& tone : tones->items()) {
      tone.allow_only({"multiple", "level_dB"});
      models.tones.push_back({tone["multiple"].number(0.01, 100), std::pow(10, tone["level_dB"].number(-120, 0) / 20)});
    }
  }
  models.teeth = json.number_or("teeth", 0, 0, 100);
  models.level = std::pow(10, json.number_or("level_dB", 0, -60, 60) / 20);
  if (const auto spray = json.find("spray")) {
    spray->allow_only({"level_dB", "source"});
    (*spray)["source"].string();
    models.spray_dB = (*spray)["level_dB"].number(0, 20);
  }
  if (const auto work = json.find("work")) {
    work->allow_only({"tissue", "force_N", "contact_area_mm2", "removal_mm3_per_s", "spindle_krpm", "level_dB",
                      "level_above_4kHz_dB", "source"});
    (*work)["source"].string();
    if (models.free_speed == 0) json.fail("no free_speed_krpm", "the speed to which the levels of \"work\" belong");
    WorkLevel measured;
    const auto tissue = tissue_named((*work)["tissue"].string());
    if (!tissue || *tissue == Tissue::kAir) (*work)["tissue"].fail("a tissue's name");
    measured.tissue = *tissue;
    measured.force = (*work)["force_N"].number(0.01, 100);
    measured.contact_area = work->number_or("contact_area_mm2", 0, 0, 100) * kSquareMillimetre;
    measured.removal_rate = work->number_or("removal_mm3_per_s", 0, 0, 1000) * kCubicMillimetre;
    measured.spindle = (*work)["spindle_krpm"].number(0.001, 1000) * kKrpm;
    measured.level_dB = (*work)["level_dB"].number(-20, 40);
    measured.high_dB = (*work)["level_above_4kHz_dB"].number(-20, 40);
    if (!calibrate(models, measured)) work->fail("levels that this voice can have");
  }
  return models;
}

}  // namespace typodont::audio
