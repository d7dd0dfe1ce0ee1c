// One run of a policy in a study: on one engine, with one command and one seed.
#pragma once

#include "common/json_text.h"
#include "policy/policy_scene.h"

namespace cogrsim::cli {

/// The measures of a policy's run, as columns of a study's table.
struct PolicyMeasure {
  const char *name, *unit;
};
inline constexpr PolicyMeasure kPolicyMeasures[] = {{"stood", "1"},
                                                    {"upright", "s"},
                                                    {"fell_at", "s"},
                                                    {"velocity_error", "m/s"},
                                                    {"turning_error", "rad/s"},
                                                    {"slip", "m/s"},
                                                    {"mean_force", "N"},
                                                    {"peak_force", "N"},
                                                    {"at_limit", "1"},
                                                    {"cost_of_transport", "1"},
                                                    {"forward", "m/s"},
                                                    {"leftward", "m/s"},
                                                    {"turning", "rad/s"}};

/// Runs a case whose scene is a card and whose parameters are PolicySettings; with `change` further ones,
/// "friction=0.5; step=1 ms". With `trace` [s] the result has what the robot's sensors would have at each
/// decision up to then, and the names of these numbers as `terms`; with `pictures` a `strip` of so many, see
/// StripCamera.
Json run_policy_case(const Json& input);

/// "0.5 0 0" as numbers. Errors: one is none.
Result<std::vector<double>> parse_command(const std::string& text);
/// Further settings of a text, "friction=0.5; step=1 ms". Errors: no "=".
Result<PolicySettings> parse_settings(const std::string& text);

}  // namespace cogrsim::cli
