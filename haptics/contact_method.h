// The contact methods by name. These names are the values of "model" in a scene and of the option --model.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/json.h"
#include "haptics/contact_model.h"
#include "haptics/tissue_body.h"
#include "haptics/tool.h"

namespace typodont::haptics {

struct ServoSettings;

/// A contact method with its parameters. Immutable; shared by the servo thread and the carver thread (which owns the
/// tissue). The make functions throw Error.
class ContactMethod {
 public:
  virtual ~ContactMethod() = default;
  virtual std::string_view name() const = 0;
  /// Returns true if the method's tissue bodies have triangles of their own, which the renderer draws
  /// (TissueBody::surface).
  virtual bool draws_own_surface() const { return false; }
  /// Creates the part that runs on the servo thread. `settings` must be complete (including the frame) and must outlive
  /// the model.
  virtual std::unique_ptr<ContactModel> make_model(const ServoSettings& settings) const = 0;
  /// Creates the part that runs on the carver thread. `tools`: the tools of the session, to which the index Cut::tool
  /// refers.
  virtual std::unique_ptr<TissueBody> make_body(TissueVolume tissue, std::span<const Tool> tools) const = 0;
};
using SharedContactMethod = std::shared_ptr<const ContactMethod>;

/// Function that reads a method's parameters from an object of the scene; nullopt: the scene contains only the method's
/// name. Throws Error.
using ContactMethodReader = std::function<SharedContactMethod(const std::optional<Json>& parameters)>;

/// Registers a contact method that another module defines. Declare an object at namespace scope in any file of the
/// program:
///   const ContactMethodRegistration registration{"mine", [](const auto& parameters) { … }};
/// Throws std::logic_error if the name already exists.
struct ContactMethodRegistration {
  ContactMethodRegistration(std::string name, ContactMethodReader reader);
};

/// Returns the method called `name`, with default parameters. If the name is unknown, throws an Error with the list of
/// names. `where`: file or option that contains the name.
SharedContactMethod contact_method(std::string_view name, std::string_view where);
/// Reads the method of a scene: "offset", or {"offset": {parameters}}. Throws Error.
SharedContactMethod read_contact_method(const Json& json);
/// Returns the full names of all methods, in the order shown to users. ("god-object" is an alias of "offset".)
std::vector<std::string> contact_method_names();
/// Returns the list of names for help and messages: "one of: offset, …".
std::string known_contact_methods();

/// For one method: the number of models (servo thread) and the number of bodies (carver thread) that this process has
/// created.
struct MethodCount {
  std::string name;
  std::uint64_t models = 0, bodies = 0;
};
/// Returns a MethodCount for each method, in the order of contact_method_names(). Thread-safe.
std::vector<MethodCount> method_counts();

/// Returns the method that is used if none is chosen: "offset".
const SharedContactMethod& default_contact_method();

}  // namespace typodont::haptics
