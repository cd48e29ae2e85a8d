// Writes a class's scores as a Parquet file.
import { parquetWriteBuffer } from './vendor/hyparquet-writer.min.js';

const TYPES = { attempt: 'INT32', received: 'TIMESTAMP', points: 'DOUBLE', passed: 'BOOLEAN', completion: 'DOUBLE', seconds: 'DOUBLE' };
const link = document.querySelector('[data-parquet]');

function column([name, data]) {
  return { name, data: name === 'received' ? data.map(time => new Date(time)) : data, type: TYPES[name] ?? 'STRING' };
}

link.addEventListener('click', async event => {
  event.preventDefault();
  const answer = await fetch(link.href);
  if (!answer.ok) return location.assign(link.href);  // the page that says why
  const columnData = Object.entries(await answer.json()).map(column);
  const file = document.createElement('a');
  file.href = URL.createObjectURL(new Blob([parquetWriteBuffer({ columnData, codec: 'UNCOMPRESSED' })]));
  file.download = link.dataset.parquet;
  file.click();
  URL.revokeObjectURL(file.href);
});
