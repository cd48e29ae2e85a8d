// The contact methods of this library and of programs that register their own.
#include "haptics/contact_method.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <mutex>
#include <stdexcept>
#include <utility>

#include "engine/base/error.h"
#include "engine/base/keys.h"
#include "haptics/contact/count_method.h"
#include "haptics/contact/implant/implant_method.h"
#include "haptics/contact/mesh_lod/mesh_lod_method.h"
#include "haptics/contact/offset/offset_method.h"
#include "haptics/contact/packing/packing_method.h"
#include "haptics/contact/vertex/vertex_method.h"
#include "haptics/contact/voxel_penalty/voxel_penalty_method.h"

namespace typodont::haptics {

namespace {

struct Entry {
  std::string name;
  ContactMethodReader read;
  std::uint64_t models = 0, bodies = 0;  // numbers of models and bodies created so far
};
std::mutex g_counts;  // protects the counters of models and bodies

/// Filled before main() starts; then only read.
std::vector<Entry>& table() {
  static std::vector<Entry> entries{
      {std::string(offset::kName), offset::read},     {std::string(implant::kName), implant::read},
      {std::string(mesh_lod::kName), mesh_lod::read}, {std::string(packing::kName), packing::read},
      {std::string(vertex::kName), vertex::read},     {std::string(voxel_penalty::kName), voxel_penalty::read}};
  return entries;
}

Entry* find(std::string_view name) {
  if (name == offset::kAlias) name = offset::kName;
  const auto found = std::ranges::find(table(), name, &Entry::name);
  return found == table().end() ? nullptr : &*found;
}

SharedContactMethod with_defaults(const Entry& entry) {
  Keys none;
  return entry.read(none);
}

}  // namespace

ContactMethodRegistration::ContactMethodRegistration(std::string name, ContactMethodReader reader) {
  if (find(name)) throw std::logic_error("contact method registered twice: " + name);
  table().push_back({std::move(name), std::move(reader)});
}

void count_method(std::string_view name, std::uint64_t models, std::uint64_t bodies) {
  const std::lock_guard lock(g_counts);
  Entry* const entry = find(name);
  // a method that is not registered is not counted
  if (!entry) return;
  entry->models += models, entry->bodies += bodies;
}

std::vector<MethodCount> method_counts() {
  const std::lock_guard lock(g_counts);
  std::vector<MethodCount> counts;
  for (const Entry& entry : table()) counts.push_back({entry.name, entry.models, entry.bodies});
  return counts;
}

std::vector<std::string> contact_method_names() {
  std::vector<std::string> names;
  for (const Entry& entry : table()) names.push_back(entry.name);
  return names;
}

std::string known_contact_methods() {
  return fmt::format("one of: {}", fmt::join(contact_method_names(), ", "));
}

SharedContactMethod contact_method(std::string_view name, std::string_view where) {
  const Entry* const entry = find(name);
  if (!entry) throw Error(std::string(where), "model", fmt::format("\"{}\"", name), known_contact_methods());
  return with_defaults(*entry);
}

SharedContactMethod read_contact_method(const Json& json) {
  if (json.is_string()) {
    const Entry* const entry = find(json.string());
    if (!entry) json.fail(known_contact_methods());
    return with_defaults(*entry);
  }
  if (!json.is_object() || json.keys().size() != 1) {
    json.fail("the name of a contact model, or an object {NAME: {parameters}}; " + known_contact_methods());
  }
  const std::string name = json.keys().front();
  const Entry* const entry = find(name);
  if (!entry) json.fail(fmt::format("\"{}\"", name), known_contact_methods());
  SharedContactMethod method;
  read_keys(json[name], [&](Keys& keys) { method = entry->read(keys); });
  return method;
}

void list_contact_methods(Keys& keys) {
  for (const Entry& entry : table()) {
    keys.alternative();
    keys(must(entry.name.c_str()), kObject, entry.read, "");
  }
}

const SharedContactMethod& default_contact_method() {
  static const SharedContactMethod method = with_defaults(*find(offset::kName));
  return method;
}

}  // namespace typodont::haptics
