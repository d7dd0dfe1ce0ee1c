// Readers of what other tools write beside policies; each fills a draft of a card.
#pragma once

#include <string>
#include <vector>

#include "policy/card_draft.h"
#include "policy/yaml_text.h"

namespace cogrsim::policy {

/// `env` is the env.yaml of the training, or nullptr.
void read_isaac_descriptors(YamlText& descriptors, YamlText* env, CardDraft& draft);
void read_unitree_deploy(YamlText& deploy, YamlText* env, CardDraft& draft);
/// `path`: of the file; names in it are looked for in the folders above.
void read_unitree_gym(YamlText& config, const std::string& path, CardDraft& draft);
/// A script of MuJoCo Playground. `path` as above; adds findings at its lines.
void read_playground(const std::string& path, const std::string& text, CardDraft& draft,
                     std::vector<Diagnostic>& found);
void read_metadata(const std::string& path, const PolicyNetwork& network, CardDraft& draft,
                   std::vector<Diagnostic>& found);

/// A finding CG1515 at a place: what a card cannot say. `key`: an answer to it lifts the finding.
void refuse(CardDraft& draft, const YamlText& yaml, const YAML::Node& at,
            const std::string& message, const std::string& help, const std::string& key = {});
void ask(CardDraft& draft, const YamlText& yaml, const YAML::Node& at, const std::string& key,
         const std::string& reason, const std::string& answer);
/// Numbers of a list, of the only row of a list of lists, or one number.
std::optional<std::vector<double>> plain_numbers(YamlText& yaml, const YAML::Node& node,
                                                 const std::string& what);
/// Decisions per second and step of the physics, both in seconds; 0: not said.
void put_times(CardDraft& draft, double period, double step);

}  // namespace cogrsim::policy
