// Unsaved changes: kept, offered again, restored.
#include <algorithm>
#include <ctime>

#include <fmt/format.h>

#include "document_impl.h"
#include "document_json.h"

namespace cogrsim::studio {

bool DocumentRequests::dirty() const { return !file_.text() || *file_.text() != history_.text(); }

std::string DocumentRequests::base() const { return file_.text() ? version_of(*file_.text()) : ""; }

void DocumentRequests::offer_found() {
  offers_.clear();
  for (const UnsavedText& one : journal_.found()) {
    const bool known = one.text == history_.text() || (file_.text() && one.text == *file_.text());
    if (!known) offers_.push_back({++last_offer_, one});
  }
  notes_ = journal_.complaints();
  if (offers_.empty()) return;
  const std::time_t time = static_cast<std::time_t>(offers_.front().unsaved.time);
  std::tm local{};
  char when[32] = "";
  if (::localtime_r(&time, &local)) std::strftime(when, sizeof when, " of %Y-%m-%d %H:%M", &local);
  notes_.push_back(
      fmt::format("'{}' has changes{} that were not saved: the page offers to restore them",
                  file_.name(), when));
}

void DocumentRequests::keep_unsaved() {
  journal_due_ = false;
  std::vector<UnsavedText> texts;
  // A new scene without a change holds no work that could be lost.
  const bool untouched = !file_.text() && history_.text() == empty_scene(file_.name());
  if (dirty() && !untouched) texts.push_back({history_.text(), base(), std::time(nullptr)});
  for (const Offer& offer : offers_) texts.push_back(offer.unsaved);
  const auto kept = journal_.keep(texts);
  const std::string why = kept ? "" : kept.error().message;
  if (why == not_kept_) return;
  not_kept_ = why;
  publish(unsaved_topic());
}

Json DocumentRequests::unsaved_topic() const {
  Json offer;
  if (!offers_.empty()) {
    const Offer& first = offers_.front();
    offer = {{"number", first.number},
             {"time", first.unsaved.time},
             {"changed", first.unsaved.base != base()},
             {"more", offers_.size() - 1}};
  }
  return {{"topic", "unsaved"},
          {"version", version_},
          {"offer", std::move(offer)},
          {"not_kept", not_kept_}};
}

std::string DocumentRequests::finish() {
  queue_->close();
  if (thread_.joinable()) thread_.join();
  if (!not_kept_.empty()) return "what was not saved is lost: " + not_kept_;
  if (journal_.path().empty()) return "";
  return "what was not saved is in '" + journal_.path() +
         "', and offered when the scene is opened again";
}

// ---- requests

Result<std::vector<DocumentRequests::Offer>::iterator> DocumentRequests::offer_of(const Request& request) {
  const auto number = request.fields.at("number").get<std::uint64_t>();
  const auto found = std::find_if(offers_.begin(), offers_.end(),
                                  [&](const Offer& offer) { return offer.number == number; });
  if (found == offers_.end()) {
    return fail("that is not offered any more: it was restored or discarded", "", "", "stale");
  }
  return found;
}

Answer DocumentRequests::unsaved(const Request& request) {
  const auto offer = offer_of(request);
  if (!offer) return tl::unexpected(offer.error());
  return Json{{"text", (*offer)->unsaved.text}};
}

Answer DocumentRequests::restore(const Request& request) {
  const auto offer = offer_of(request);
  if (!offer) return tl::unexpected(offer.error());
  if (history_.change((*offer)->unsaved.text, "restore")) changed(request.client);
  offers_.erase(*offer);
  journal_due_ = true;
  publish(unsaved_topic());
  return Json{{"version", version_}};
}

Answer DocumentRequests::discard(const Request& request) {
  const auto offer = offer_of(request);
  if (!offer) return tl::unexpected(offer.error());
  offers_.erase(*offer);
  journal_due_ = true;
  publish(unsaved_topic());
  return Json::object();
}

}  // namespace cogrsim::studio
