#include "engine/app/operator/exercise.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <nlohmann/json.hpp>

#include "engine/app/operator/library.h"
#include "engine/base/error.h"
#include "engine/base/json.h"
#include "engine/base/units.h"

namespace typodont {

namespace {

namespace fs = std::filesystem;
using Text = nlohmann::ordered_json;

Text mm(const dvec3& p) {
  const auto micrometre = [](double v) { return std::round(v / kMillimetre * 1000) / 1000; };
  return {micrometre(p.x), micrometre(p.y), micrometre(p.z)};
}

Text paint_entry(const PaintStroke& s) {
  const double radius = s.radius / kMillimetre;
  Text solid;
  if (s.a_W == s.b_W) {
    solid["sphere"] = {{"center_mm", mm(s.a_W)}, {"radius_mm", radius}};
  } else {
    solid["capsule"] = {{"a_mm", mm(s.a_W)}, {"b_mm", mm(s.b_W)}, {"radius_mm", radius}};
  }
  return {{"tissue", std::string(name_of(s.tissue))}, {"solid", solid}};
}

}  // namespace

std::string exercise_json(const NewExercise& e, const std::string& ideal_file) {
  Text scene = Text::parse(e.base->text);
  scene["name"] = e.name;
  scene["description"] = e.goal;
  for (const PaintStroke& stroke : e.strokes) scene["paint"].push_back(paint_entry(stroke));
  // A volume that lies beside the base is not beside the new scene.
  if (scene["tissue"].contains("volume")) {
    const fs::path beside = e.base->file.parent_path() / scene["tissue"]["volume"].get<std::string>();
    std::error_code code;
    if (fs::exists(beside, code)) scene["tissue"]["volume"] = fs::absolute(beside).string();
  }
  if (!ideal_file.empty()) {
    Text& task = scene["task"];
    if (!task.is_object()) task = Text::object();
    task.erase("explore");
    task["goal"] = e.goal.empty() ? e.name : e.goal;
    task["ideal"] = {{"volume", ideal_file}};
  }
  return scene.dump(2) + "\n";
}

fs::path write_exercise(const NewExercise& e) {
  std::string stem;
  for (const char c : e.name) {
    const auto u = static_cast<unsigned char>(c);
    stem += std::isalnum(u) || u >= 0x80 || c == '-' ? static_cast<char>(std::tolower(u)) : '_';
  }
  const fs::path folder = user_folder() / "scenes", file = folder / (stem + ".json");
  std::error_code code;
  fs::create_directories(folder, code);
  if (code) throw Error(folder.string(), "", code.message(), "a folder that can be made");
  const std::string ideal = e.ideal ? stem + "-ideal.vdb" : "";
  if (e.ideal) e.ideal->save(folder / ideal);
  write_file_atomically(file, exercise_json(e, ideal));
  return file;
}

}  // namespace typodont
