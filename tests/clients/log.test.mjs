// @mcap/core, the reader of the Foxglove app, reads the same messages from phalanx's logs by index and as a stream.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import path from "node:path";
import { after, describe, it } from "node:test";
import { fileURLToPath } from "node:url";

import { McapIndexedReader, McapStreamReader } from "@mcap/core";
import { decompress } from "fzstd";
import protobuf from "protobufjs";
import "protobufjs/ext/descriptor.js";

const PROJECT = fileURLToPath(new URL("../../", import.meta.url));
const PHALANX = process.env.PHALANX ?? path.join(PROJECT, "target/debug/phalanx");
const DIRECTORY = mkdtempSync(path.join(tmpdir(), "phalanx-clients-"));
after(() => rmSync(DIRECTORY, { recursive: true }));

const decompressHandlers = { zstd: (data, size) => decompress(data, new Uint8Array(Number(size))) };

/** JSON output of the program. */
const phalanx = (...args) => JSON.parse(execFileSync(PHALANX, [...args, "--json"], { encoding: "utf8" }));

/** Runs a scene with a log; returns the JSON output and the path of the log. */
function run(scene, ...options) {
  const log = path.join(DIRECTORY, `${path.basename(scene)}${options.join("")}.mcap`);
  return { log, summary: phalanx("run", path.join(PROJECT, "scenes", scene), "--log", log, ...options) };
}

/** Reads the messages of a log through its index; also returns the reader. */
async function readIndexed(log) {
  const bytes = readFileSync(log);
  const readable = {
    size: async () => BigInt(bytes.length),
    read: async (offset, size) => new Uint8Array(bytes.subarray(Number(offset), Number(offset + size))),
  };
  const reader = await McapIndexedReader.Initialize({ readable, decompressHandlers });
  const messages = [];
  for await (const message of reader.readMessages()) {
    messages.push(message);
  }
  return { reader, messages };
}

/** Reads the records of a log as a stream of chunks of 10,000 bytes. */
function readStream(log) {
  const bytes = readFileSync(log);
  const reader = new McapStreamReader({ decompressHandlers, validateCrcs: true });
  const found = { messages: [], channels: new Map(), schemas: new Map(), attachments: [], metadata: [] };
  for (let at = 0; at < bytes.length; at += 10_000) {
    reader.append(bytes.subarray(at, at + 10_000));
    for (let record; (record = reader.nextRecord()) != undefined; ) {
      if (record.type === "Message") found.messages.push(record);
      if (record.type === "Channel") found.channels.set(record.id, record);
      if (record.type === "Schema") found.schemas.set(record.id, record);
      if (record.type === "Attachment") found.attachments.push(record);
      if (record.type === "Metadata") found.metadata.push(record);
    }
  }
  assert.ok(reader.done());
  return found;
}

/** Message types by channel, from the embedded descriptors only. */
function messageTypes({ channels, schemas }) {
  const types = new Map();
  for (const { id, schemaId, messageEncoding } of channels.values()) {
    const schema = schemas.get(schemaId);
    assert.equal(messageEncoding, "protobuf");
    assert.equal(schema.encoding, "protobuf");
    const root = protobuf.Root.fromDescriptor(schema.data, { keepCase: true });
    types.set(id, root.lookupType(schema.name));
  }
  return types;
}

/** Decodes the messages, by topic. */
function decodeByTopic(found) {
  const types = messageTypes(found);
  const topics = new Map([...found.channels.values()].map(({ topic }) => [topic, []]));
  for (const { channelId, data } of found.messages) {
    topics.get(found.channels.get(channelId).topic).push(types.get(channelId).decode(data));
  }
  return topics;
}

for (const [scene, ...options] of [
  ["experiment-95.toml"],
  ["experiment-95.toml", "--model", "engine"],
  ["free-swing.toml"],
  ["laws/impact.toml"],
]) {
  describe([scene, ...options].join(" "), () => {
    const { log, summary } = run(scene, ...options);

    it("reads the same messages through the index and as a stream", async () => {
      const { reader, messages } = await readIndexed(log);
      const stream = readStream(log);
      const key = ({ channelId, sequence }) => channelId * 2 ** 32 + sequence;
      const byKey = new Map(messages.map((message) => [key(message), message]));
      assert.equal(byKey.size, messages.length);
      assert.equal(stream.messages.length, messages.length);
      for (const message of stream.messages) {
        assert.deepEqual(byKey.get(key(message)), message);
      }
      assert.ok(messages.every(({ logTime }, at) => at === 0 || messages[at - 1].logTime <= logTime));
      assert.equal(reader.statistics.messageCount, BigInt(messages.length));
      assert.equal(phalanx("replay", log).messages, messages.length);
      const counts = new Map();
      for (const { channelId } of messages) {
        counts.set(channelId, (counts.get(channelId) ?? 0n) + 1n);
      }
      assert.deepEqual(new Map([...reader.statistics.channelMessageCounts].filter(([, n]) => n > 0n)), counts);
    });

    it("decodes every message with the embedded descriptors; the values equal --json", () => {
      const topics = decodeByTopic(readStream(log));
      for (const [key, value] of Object.entries(summary.energy)) {
        assert.equal(topics.get("/energy").at(-1)[key], value, key);
      }
      for (const [key, value] of Object.entries(summary.final ?? {})) {
        const [, rate, index] = key.match(/^q(d?)(\d\d)_/);
        const last = (joint) => topics.get(`/joint/q${joint}`).at(-1)[rate ? "rate_rad_s" : "angle_rad"];
        // q13 is the orientation of l22.
        assert.equal(index === "13" ? last("21") + last("22") : last(index), value, key);
      }
      for (const [name, { first_s, touchdowns }] of Object.entries(summary.contacts)) {
        const touches = topics.get("/event").filter(({ subject, kind }) => subject === name && kind === "touch_down");
        assert.equal(touches.length, touchdowns, name);
        assert.equal(touches[0]?.timestamp ?? null, first_s, name);
      }
      assert.equal(topics.get("/events").at(-1).message, "completed");
    });

    it("contains the scene byte for byte, and the metadata", () => {
      const { attachments, metadata } = readStream(log);
      assert.equal(attachments.length, 1);
      assert.deepEqual(Buffer.from(attachments[0].data), readFileSync(path.join(PROJECT, "scenes", scene)));
      assert.deepEqual(metadata.map(({ name }) => name), ["phalanx", "phalanx-subjects", "phalanx-check"]);
      assert.equal(metadata[0].metadata.get("model"), summary.model);
      assert.ok(metadata[1].metadata.size > 0);
      assert.equal(metadata[2].metadata.get("verdict"), summary.check.verdict);
    });
  });
}
