// One robot on an ESP32 with the Arduino core 3: ESP-NOW as radio, one step per second.

#include <WiFi.h>
#include <esp_now.h>

#define FEASIBEE_INBOX 32
#define FEASIBEE_ID uint32_t  // the last four bytes of a board's address
#include "feasibee.h"

const uint32_t STEP_MS = 1000;
const uint8_t EVERYONE[6] = {0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF};

// A message is one byte, as in examples/micropython; ESP-NOW adds the sender and a checksum.
enum : uint8_t { FEASIBLE = 1, DECLARED = 2 };

struct Packet {
  uint32_t sender;
  uint8_t flags;
};

static QueueHandle_t packets;  // from the task of the radio to that of the sketch
static struct feasibee_settings settings;
static struct feasibee_robot robot;
static uint32_t next_step;

// Replace these by your camera or sensor: how many other robots and tasks are in sight.
static uint16_t robots_in_sight() { return 0; }
static uint16_t tasks_in_sight() { return 0; }

static uint32_t draw_duration(void *, const struct feasibee_mean *mean) {
  return feasibee_exponential(mean, esp_random());
}

static struct feasibee_choice draw_choice(void *) {
  struct feasibee_choice choice;
  choice.chance = esp_random();
  choice.message = esp_random();
  return choice;
}

static void on_receive(const esp_now_recv_info_t *info, const uint8_t *data, int length) {
  if (length != 1 || data[0] > (FEASIBLE | DECLARED)) return;  // not ours
  Packet packet = {0, data[0]};
  memcpy(&packet.sender, info->src_addr + 2, 4);
  xQueueSend(packets, &packet, 0);  // without room it is lost
}

void setup() {
  Serial.begin(115200);
  packets = xQueueCreate(64, sizeof(Packet));
  WiFi.mode(WIFI_STA);
  esp_now_peer_info_t everyone = {};
  memcpy(everyone.peer_addr, EVERYONE, 6);
  if (esp_now_init() != ESP_OK || esp_now_register_recv_cb(on_receive) != ESP_OK ||
      esp_now_add_peer(&everyone) != ESP_OK) {
    Serial.println("ESP-NOW doesn't start");
    return;
  }
  settings = feasibee_defaults(&feasibee_dmmd);
  settings.draw_duration = draw_duration;
  settings.draw_choice = draw_choice;
  settings.declare.rounds = 3;
  struct feasibee_me me = {};
  feasibee_begin(&robot, &settings, &me, esp_random() & 1);
  next_step = millis() + STEP_MS;
}

static void hear_all() {
  Packet packet;
  while (xQueueReceive(packets, &packet, 0) == pdTRUE) {
    struct feasibee_message message = {};
    message.opinion = packet.flags & FEASIBLE ? FEASIBEE_FEASIBLE : FEASIBEE_INFEASIBLE;
    if (feasibee_listens(&robot)) feasibee_hear(&robot, packet.sender, &message);
  }
}

void loop() {
  if (settings.strategy == nullptr || (int32_t)(millis() - next_step) < 0) return;
  next_step += STEP_MS;
  feasibee_observe(&robot, robots_in_sight(), tasks_in_sight());
  hear_all();
  struct feasibee_message message;
  if (feasibee_message(&robot, &message)) {
    uint8_t flags = message.opinion == FEASIBEE_FEASIBLE ? FEASIBLE : 0;
    if (message.declared) flags |= DECLARED;
    esp_now_send(EVERYONE, &flags, 1);
  }
  bool knew = robot.declared != FEASIBEE_NONE;
  feasibee_end_step(&robot);
  if (robot.declared != FEASIBEE_NONE && !knew) {
    Serial.println(robot.opinion == FEASIBEE_FEASIBLE ? "feasible" : "infeasible");
  }
}
