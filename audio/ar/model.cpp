#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "audio/ar/levinson.h"
#include "audio/ar_model.h"
#include "engine/base/json.h"
#include "engine/base/units.h"

namespace typodont::audio {

namespace {

constexpr std::size_t kMaxLines = 64, kMaxLineOrder = 128;

double power_of_process(const std::vector<double>& reflection, double gain) {
  double power = gain * gain;
  for (const double k : reflection) power /= 1 - k * k;
  return power;
}

std::vector<double> read_reflection(const Json& array, std::size_t most) {
  if (!array.is_array()) array.fail("an array of numbers");
  std::vector<double> reflection;
  for (const Json& item : array.items()) {
    const double k = item.number();
    if (!(std::abs(k) < 1)) item.fail("a number between -1 and 1, both excluded: else the filter is not stable");
    reflection.push_back(k);
  }
  if (reflection.size() > most) array.fail(fmt::format("more than {} numbers", most), fmt::format("at most {}", most));
  return reflection;
}

LineNoise read_noise(const Json& json, double max_gain) {
  json.allow_only({"gain", "reflection_coefficients"});
  return {read_reflection(json["reflection_coefficients"], kMaxLineOrder), json["gain"].number(0, max_gain)};
}

ModelLine read_line(const Json& json, double rate) {
  json.allow_only({"frequency_Hz", "amplitude", "amplitude_noise", "frequency_noise_Hz"});
  ModelLine line;
  line.frequency = json["frequency_Hz"].number(1, rate / 2);
  line.amplitude = json["amplitude"].number(1e-9, 10);
  line.amplitude_noise = read_noise(json["amplitude_noise"], 10);
  line.frequency_noise = read_noise(json["frequency_noise_Hz"], rate / 2);
  return line;
}

nlohmann::ordered_json as_json(const LineNoise& noise) {
  return {{"gain", noise.gain}, {"reflection_coefficients", noise.reflection}};
}

}  // namespace

double LineNoise::deviation() const {
  return std::sqrt(power_of_process(reflection, gain));
}

double power_of(const ArModel& model) {
  double power = power_of_process(model.reflection, model.gain);
  for (const ModelLine& line : model.lines) {
    const double varies = line.amplitude_noise.deviation();
    power += line.amplitude * line.amplitude / 2 * (1 + varies * varies);
  }
  return power;
}

std::vector<double> spectrum_dB(const ArModel& model, const std::vector<double>& frequencies) {
  std::vector<double> result;
  for (const double f : frequencies) {
    const double power = predictor_power(model.reflection, 2 * kPi * f / model.rate);
    result.push_back(10 * std::log10(2 * model.gain * model.gain / (model.rate * power) + 1e-30));
  }
  return result;
}

ArModel truncated(const ArModel& model, std::size_t order) {
  ArModel result = model;
  while (result.reflection.size() > order) {
    const double k = result.reflection.back();
    result.gain /= std::sqrt(1 - k * k);
    result.reflection.pop_back();
  }
  return result;
}

std::size_t sufficient_order(const ArModel& model) {
  if (model.samples == 0) return model.order();
  const double n = static_cast<double>(model.samples);
  double log_variance = 0, least = 0;
  std::size_t best = 0;
  for (std::size_t m = 1; m <= model.order(); ++m) {
    log_variance += std::log1p(-model.reflection[m - 1] * model.reflection[m - 1]);
    const double criterion = n * log_variance + static_cast<double>(m) * std::log(n);
    if (criterion < least) {
      least = criterion;
      best = m;
    }
  }
  return best;
}

ArModel load_model(const std::filesystem::path& file) {
  const Json json = Json::load(file);
  json.allow_only({"kind", "name", "order", "method", "rate_Hz", "gain", "residual_variance", "samples", "spindle_krpm",
                   "spindle_estimated", "source", "licence", "notes", "reflection_coefficients", "lines"});
  if (const auto kind = json.find("kind"); kind && kind->string() != "ar_model") kind->fail("\"ar_model\"");
  ArModel model;
  model.rate = json["rate_Hz"].number(1000, 1e6);
  model.gain = json["gain"].number(0, 1e6);
  model.name = json.string_or("name", file.stem().string());
  model.method = json.string_or("method", "");
  model.source = json.string_or("source", "");
  model.licence = json.string_or("licence", "");
  model.notes = json.string_or("notes", "");
  if (const auto samples = json.find("samples")) model.samples = static_cast<std::size_t>(samples->integer(0));
  model.spindle = json.number_or("spindle_krpm", 0, 0, 1000) * kKrpm;
  model.spindle_estimated = json.boolean_or("spindle_estimated", false);
  const Json reflection = json["reflection_coefficients"];
  model.reflection = read_reflection(reflection, 10000);
  if (const auto lines = json.find("lines")) {
    if (!lines->is_array()) lines->fail("an array of lines");
    for (const Json& line : lines->items()) model.lines.push_back(read_line(line, model.rate));
    if (model.lines.size() > kMaxLines)
      lines->fail(fmt::format("{} lines", model.lines.size()), fmt::format("at most {}", kMaxLines));
  }
  if (const auto order = json.find("order"); order && order->integer() != static_cast<long long>(model.order())) {
    order->fail(std::to_string(model.order()) + ", the number of reflection coefficients");
  }
  if (const auto variance = json.find("residual_variance")) {
    const double found = variance->number(0);
    if (std::abs(found - model.gain * model.gain) > 1e-6 * (found + model.gain * model.gain)) {
      variance->fail("the square of \"gain\"");
    }
  }
  return model;
}

std::string to_json(const ArModel& model) {
  nlohmann::ordered_json json;
  json["kind"] = "ar_model";
  json["name"] = model.name;
  json["order"] = model.order();
  json["method"] = model.method;
  json["rate_Hz"] = model.rate;
  json["gain"] = model.gain;
  json["residual_variance"] = model.gain * model.gain;
  json["samples"] = model.samples;
  if (model.spindle > 0) {
    json["spindle_krpm"] = model.spindle / kKrpm;
    json["spindle_estimated"] = model.spindle_estimated;
  }
  json["source"] = model.source;
  json["licence"] = model.licence;
  if (!model.notes.empty()) json["notes"] = model.notes;
  for (const ModelLine& line : model.lines) {
    json["lines"].push_back({{"frequency_Hz", line.frequency},
                             {"amplitude", line.amplitude},
                             {"amplitude_noise", as_json(line.amplitude_noise)},
                             {"frequency_noise_Hz", as_json(line.frequency_noise)}});
  }
  json["reflection_coefficients"] = model.reflection;
  // Writes one field per row, and eight coefficients per row, so that diffs are short.
  std::string text = "{\n";
  for (const auto& [key, value] : json.items()) {
    if (text.size() > 2) text += ",\n";
    text += fmt::format("  \"{}\": ", key);
    if (!value.is_array()) {
      text += value.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
      continue;
    }
    text += "[";
    const std::size_t in_a_row = key == "lines" ? 1 : 8;
    for (std::size_t i = 0; i < value.size(); ++i) {
      text += fmt::format("{}{}{}", i > 0 ? "," : "", i % in_a_row == 0 ? "\n    " : " ", value[i].dump());
    }
    text += "\n  ]";
  }
  return text + "\n}\n";
}

}  // namespace typodont::audio
