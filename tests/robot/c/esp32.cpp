// Run the sketch for 600 seconds among five robots that say infeasible; print the last byte that it sent.

#include "feasibee_robot.ino"

#include <cstdio>

struct Queue {
  size_t length, size;
  std::deque<Packet> items;
};

static unsigned long now;
static esp_now_recv_cb_t receiver;
static int sent = -1;
SerialPort Serial;
Network WiFi;

QueueHandle_t xQueueCreate(UBaseType_t length, UBaseType_t size) { return new Queue{length, size, {}}; }

BaseType_t xQueueSend(QueueHandle_t queue, const void *item, TickType_t) {
  if (queue->items.size() == queue->length || queue->size != sizeof(Packet)) return 0;
  queue->items.push_back(*static_cast<const Packet *>(item));
  return pdTRUE;
}

BaseType_t xQueueReceive(QueueHandle_t queue, void *item, TickType_t) {
  if (queue->items.empty()) return 0;
  *static_cast<Packet *>(item) = queue->items.front();
  queue->items.pop_front();
  return pdTRUE;
}

void SerialPort::begin(unsigned long) {}
void SerialPort::println(const char *line) { puts(line); }
bool Network::mode(wifi_mode_t mode) { return mode == WIFI_MODE_STA; }
unsigned long millis() { return now; }
esp_err_t esp_now_init() { return ESP_OK; }

esp_err_t esp_now_add_peer(const esp_now_peer_info_t *peer) {
  return peer->peer_addr[5] == 0xFF ? ESP_OK : 1;
}

uint32_t esp_random() {
  static uint32_t state = 1;
  state = state * 1664525 + 1013904223;
  return state;
}

esp_err_t esp_now_register_recv_cb(esp_now_recv_cb_t callback) {
  receiver = callback;
  return ESP_OK;
}

esp_err_t esp_now_send(const uint8_t *address, const uint8_t *data, size_t length) {
  sent = length == 1 && address[0] == 0xFF ? data[0] : -2;
  return ESP_OK;
}

int main() {
  setup();
  for (now = 0; now < 600000; now += 10) {
    uint8_t address[6] = {2, 0, 0, 0, 0, (uint8_t)(now / 10 % 5)}, infeasible = 0, noise[2] = {1, 2};
    esp_now_recv_info_t info = {address, address, nullptr};
    if (now % 100 < 50) receiver(&info, &infeasible, 1);
    receiver(&info, noise, 2);
    loop();
  }
  printf("%d\n", sent);
}
