#include "engine/app/experiment/abx.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <random>
#include <sstream>

#include "engine/base/base64.h"
#include "engine/base/error.h"
#include "engine/base/input_file.h"
#include "engine/base/json.h"
#include "engine/base/markup.h"

namespace typodont {

AbxKey abx_key(const std::string& a, const std::string& b, int trials, std::uint64_t seed) {
  AbxKey key{a, b, seed, std::vector<bool>(static_cast<std::size_t>(trials))};
  std::mt19937_64 random(seed);
  const bool odd_is_b = random() & 1;
  for (std::size_t i = 0; i < key.x_is_b.size(); ++i) key.x_is_b[i] = (i % 2 == 0) == odd_is_b;
  // Shuffles with the Fisher-Yates algorithm. std::shuffle is not used, because its order differs between standard
  // libraries.
  for (std::size_t i = key.x_is_b.size(); i > 1; --i) {
    const std::size_t j = random() % i;
    const bool kept = key.x_is_b[i - 1];
    key.x_is_b[i - 1] = key.x_is_b[j];
    key.x_is_b[j] = kept;
  }
  return key;
}

std::string to_json(const AbxKey& key) {
  nlohmann::ordered_json j;
  j["kind"] = "abx_key";
  j["a"] = key.a;
  j["b"] = key.b;
  j["seed"] = key.seed;
  j["x"] = nlohmann::ordered_json::array();
  for (const bool b : key.x_is_b) j["x"].push_back(b ? "B" : "A");
  return j.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

AbxKey load_abx_key(const std::filesystem::path& file) {
  const Json json = Json::load(file);
  json.allow_only({"kind", "a", "b", "seed", "x"});
  if (json["kind"].string() != "abx_key") json["kind"].fail("abx_key");
  AbxKey key{json["a"].string(), json["b"].string(), static_cast<std::uint64_t>(json["seed"].integer()), {}};
  for (const Json& x : json["x"].items()) {
    if (x.string() != "A" && x.string() != "B") x.fail("A or B");
    key.x_is_b.push_back(x.string() == "B");
  }
  if (key.x_is_b.empty()) json["x"].fail("at least one trial");
  return key;
}

std::vector<bool> load_abx_answers(const std::filesystem::path& file, std::size_t trials) {
  LineReader in(file, InputKind::kTable);
  std::vector<int> said(trials, -1);
  std::string line;
  for (int number = 1; in.next(line); ++number) {
    std::istringstream words(line);
    std::size_t trial = 0;
    std::string answer, rest;
    if (!(words >> trial)) {
      if (line.find_first_not_of(" \t\r") == std::string::npos) continue;  // ignores an empty line
      trial = 0;
    }
    words >> answer;
    const bool valid = trial >= 1 && trial <= trials && (answer == "A" || answer == "B") && !(words >> rest);
    if (!valid || said[trial - 1] >= 0)
      throw Error(file.string(), fmt::format("line {}", number), "\"" + line.substr(0, 40) + "\"",
                  fmt::format("a trial from 1 to {}, once, and A or B", trials));
    said[trial - 1] = answer == "B";
  }
  std::vector<bool> result;
  for (std::size_t i = 0; i < trials; ++i) {
    if (said[i] < 0) throw Error(file.string(), fmt::format("trial {}", i + 1), "no answer", "A or B");
    result.push_back(said[i] == 1);
  }
  return result;
}

AbxResult judge(const AbxKey& key, const std::vector<bool>& said_b) {
  AbxResult result;
  result.trials = static_cast<int>(key.x_is_b.size());
  for (std::size_t i = 0; i < key.x_is_b.size(); ++i) result.right += said_b[i] == key.x_is_b[i];
  result.fraction = fraction_of(result.right, result.trials);
  result.chance = chance_of(result.right, result.trials);
  return result;
}

std::string abx_page(const AbxKey& key, const std::vector<std::vector<std::uint8_t>>& sounds) {
  const auto player = [&](std::size_t i) {
    return fmt::format("<audio controls preload=\"auto\" src=\"data:audio/wav;base64,{}\"></audio>", base64(sounds[i]));
  };
  std::string page =
      page_head("Blind listening",
                "body{font:16px/1.5 system-ui,sans-serif;max-width:50rem;margin:2rem auto;padding:0 1rem;color:#1d2330;"
                "background:#fff}fieldset{border:1px solid #c9ced8;margin:.6rem 0}audio{vertical-align:middle}"
                "label{margin-left:1rem}textarea{width:100%;height:8rem}");
  page +=
      "<p>Listen to A and B with headphones, as often as you like. In each trial, X is another part of one of them: "
      "say of which. If you cannot tell, guess. All parts are equally loud.</p>\n";
  page += fmt::format("<p>A {}</p>\n<p>B {}</p>\n<form id=\"trials\">\n", player(0), player(1));
  for (std::size_t i = 0; i < key.x_is_b.size(); ++i) {
    page += fmt::format(
        "<fieldset><legend>{0}</legend>X {1}<label><input type=\"radio\" name=\"t{0}\" value=\"A\"> A</label><label>"
        "<input type=\"radio\" name=\"t{0}\" value=\"B\"> B</label></fieldset>\n",
        i + 1, player(i + 2));
  }
  page += fmt::format(
      "</form>\n<p>Answers, for a text file (<code>typodont sound abx --key KEY.json --answers FILE</code>):</p>\n"
      "<textarea id=\"answers\" readonly></textarea>\n<script>\nconst form=document.getElementById('trials');"
      "form.addEventListener('change',()=>{{let text='';for(let i=1;i<={};++i){{const "
      "chosen=form.elements['t'+i].value;"
      "if(chosen)text+=i+' '+chosen+'\\n';}}document.getElementById('answers').value=text;}});\n</script>\n"
      "</body></html>\n",
      key.x_is_b.size());
  return page;
}

}  // namespace typodont
