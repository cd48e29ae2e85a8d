#include <cmath>

#include "audio/sound_models.h"
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
  json.allow_only({"kind", "name", "idle", "working", "free_speed_krpm", "order", "tones", "teeth", "level_dB",
                   "source", "licence", "notes"});
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
  return models;
}

}  // namespace typodont::audio
