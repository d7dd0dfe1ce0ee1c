// The options of cogrsim push, pull and list.
#include <memory>

#include <CLI/CLI.hpp>

#include "common/arguments.h"
#include "share.h"

namespace cogrsim::share {
namespace {

void add_store_options(CLI::App& command, StoreOptions& store) {
  command
      .add_option("--endpoint", store.endpoint,
                  "Endpoint of an s3:// store; default: AWS_ENDPOINT_URL, else Amazon's")
      ->type_name("URL");
  command
      .add_option("--timeout", store.stall_timeout,
                  "Longest time without an answer from the store [s]")
      ->type_name("S")
      ->check(CLI::Range(1, 3600))
      ->capture_default_str();
}

constexpr const char* kStores =
    "STORE is https://host/folder (WebDAV; COGRSIM_STORE_USER and COGRSIM_STORE_PASSWORD, or\n"
    "~/.netrc) or s3://bucket/prefix (AWS_ACCESS_KEY_ID, AWS_SECRET_ACCESS_KEY, AWS_REGION,\n"
    "AWS_ENDPOINT_URL); COGRSIM_STORE names the default store.";

void add_push(CLI::App& app, int& status) {
  CLI::App& command = *app.add_subcommand("push", "Pack a scene and put it into a store");
  const auto options = std::make_shared<PushOptions>();
  command.add_option("scene", options->scene, "Scene file, NAME.scene.xml")
      ->required()
      ->type_name("SCENE");
  command.add_option("--to", options->store.address, "Store to push to")
      ->envname("COGRSIM_STORE")
      ->type_name("STORE");
  command
      .add_option("--name", options->name,
                  "Name of the package; default: made of the scene's file name")
      ->type_name("NAME");
  command.add_option("--version", options->version, "Version: numbers with points, such as 1.0.2")
      ->type_name("V")
      ->capture_default_str();
  command
      .add_option("--description", options->description,
                  "Description of the scene, in a sentence or two")
      ->type_name("TEXT");
  command.add_option("--author", options->author, "Author of the package")->type_name("TEXT");
  command.add_option("--licence,--license", options->licence, "Licence of the package")
      ->type_name("TEXT");
  cli::add_list(command, "--include", options->include,
                "A further file: a recording, or one below the scene's folder; may be repeated",
                "FILE");
  command
      .add_option("-o,--output", options->output,
                  "Write the package to this file or folder instead of a store")
      ->type_name("FILE|DIR");
  command.add_flag("--force", options->force, "Replace the same version if it is there");
  command.add_flag("--dry-run", options->dry_run, "List what would be packed, and send nothing");
  cli::add_list(command, "--plugin-path", options->plugin_paths,
                "Folder in which plugins are looked for first; may be repeated", "DIR");
  add_store_options(command, options->store);
  command.footer(
      std::string("Examples:\n"
                  "  cogrsim push arm.scene.xml --to https://cloud.example.org/dav/scenes \\\n"
                  "      --version 1.1 --author \"A. Body\" --licence CC-BY-4.0\n"
                  "  cogrsim push arm.scene.xml --to s3://robots/scenes --include best.mcap\n"
                  "  cogrsim push arm.scene.xml --dry-run      what would be in it\n"
                  "  cogrsim push arm.scene.xml -o .           a file to hand on\n") +
      kStores);
  command.callback([options, &status] { status = push_command(*options); });
}

void add_pull(CLI::App& app, int& status) {
  CLI::App& command = *app.add_subcommand("pull", "Fetch a package, verify and unpack it");
  const auto options = std::make_shared<PullOptions>();
  command
      .add_option("package", options->package,
                  "Name of the package, the newest version unless one is given; or a file on this "
                  "machine")
      ->required()
      ->type_name("NAME[@VERSION]|FILE.cogrsim.zip");
  command.add_option("--from", options->store.address, "Store to pull from")
      ->envname("COGRSIM_STORE")
      ->type_name("STORE");
  command
      .add_option("--into", options->into,
                  "Folder in which NAME-VERSION is made, which must not exist")
      ->type_name("DIR")
      ->capture_default_str();
  command.add_flag("--dry-run", options->dry_run, "Verify the package and write nothing");
  add_store_options(command, options->store);
  command.footer(
      std::string(
          "Examples:\n"
          "  cogrsim pull arm --from https://cloud.example.org/dav/scenes\n"
          "  cogrsim pull arm@1.0.2 --into examples\n"
          "  cogrsim pull ./arm-1.0.2.cogrsim.zip      a file from elsewhere\n"
          "Nothing of a package is built or run: it says what to do with sources in it.\n") +
      kStores);
  command.callback([options, &status] { status = pull_command(*options); });
}

void add_list_command(CLI::App& app, int& status) {
  CLI::App& command = *app.add_subcommand("list", "List the packages of a store");
  const auto options = std::make_shared<ListOptions>();
  command.add_option("store", options->store.address, "Store")
      ->envname("COGRSIM_STORE")
      ->type_name("STORE");
  cli::add_json(command, options->json);
  add_store_options(command, options->store);
  command.footer(std::string("Examples:\n"
                             "  cogrsim list https://cloud.example.org/dav/scenes\n"
                             "  cogrsim list s3://robots/scenes --endpoint https://s3.example.org\n"
                             "  cogrsim list --json | jq -r '.[].name'\n") +
                 kStores);
  command.callback([options, &status] { status = list_command(*options); });
}

}  // namespace

void add_share(CLI::App& app, int& status) {
  add_push(app, status);
  add_pull(app, status);
  add_list_command(app, status);
}

}  // namespace cogrsim::share
